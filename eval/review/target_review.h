// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "eval/review/feature_errors.h"

namespace sightline {

/// The page by which a user judges a target's features: the target from six sides with every
/// feature marked and named, and for each feature from how many sides it is to be seen, how often
/// it is found and by how much it errs. One HTML file with the report's looks, which needs no
/// network. `file` names the target in the commands that change it.
std::string review_page(const std::shared_ptr<const Target>& target,
                        const std::vector<FeatureError>& errors, const std::string& file);

/// Writes that page for a target.toml or a target's name. Throws InputError for a target that
/// cannot be rendered or has no features, and for a page that cannot be written or does not end in
/// .html.
void write_review(const std::string& target, const std::filesystem::path& page);

}  // namespace sightline
