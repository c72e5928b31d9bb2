// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace sightline {

/// What `sightline list keys TABLE` prints: the keys of a table of scene and study files (of all
/// tables where `table` is empty) with unit, range, default and meaning, from the tables that read
/// them. Throws InputError for a table that does not exist.
std::string key_list(const std::string& table);

/// The same as JSON, an object for each table.
std::string key_json(const std::string& table);

/// The same for all tables as a page, docs/keys.md.
std::string key_page();

/// The two lines with which a page of docs/ begins, its licence, and an empty one.
std::string page_licence();

}  // namespace sightline
