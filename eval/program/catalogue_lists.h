// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace sightline {

/// What `sightline list` prints, made from the catalogues and the assets: `what` is targets,
/// extractors, solvers, methods (of absolute orientation), studies, or empty for all of these;
/// columns (of results, as Markdown), measures (that `compare` takes). Throws InputError for any
/// other word. What is in a file's keys is in key_lists.h.
std::string catalogue_lists(const std::string& what);

/// The lists of names, or one of them, as JSON: an array of objects with `name` and `text` each.
/// Throws InputError for what has none.
std::string catalogue_json(const std::string& what);

}  // namespace sightline
