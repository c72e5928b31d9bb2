// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace sightline {

using Json = nlohmann::ordered_json;

/// What a file of somebody's holds. Throws InputError, with the file, where it is missing, no
/// regular file (a pipe or a device would never end), over 1 GiB, no JSON, or nested deeper than
/// 100 arrays and objects, which no format that we read is: what walks through JSON calls itself.
Json read_json(const std::filesystem::path& file);

/// Calls `use` with what read_json gives. Throws InputError, with the file, where it lacks what
/// `use` asks it for.
void with_json(const std::filesystem::path& file, const std::function<void(const Json&)>& use);

/// The finite numbers of an array of that length; throws InputError where it is none.
std::vector<double> numbers_in(const Json& json, const std::string& key, size_t count);

}  // namespace sightline
