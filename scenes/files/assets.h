// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sightline {

/// Where the shipped targets, studies and the report's page lie: the folder named by the
/// environment variable SIGHTLINE_ASSETS, else the one that is to be used, else share/sightline
/// beside the installed program, else the source tree's assets/.
std::filesystem::path assets_folder();

/// Names the folder to be used, for whoever is not the installed program but knows where that is.
void use_assets(const std::filesystem::path& folder);

/// The names of the shipped targets (folders with a target.toml) and studies (.toml), sorted.
std::vector<std::string> target_names();
std::vector<std::string> study_names();

/// The file of a target or study given by name or by path: what holds a '/' or has an extension is
/// a path. Throws InputError, with a suggestion, when there is no such name.
std::filesystem::path find_target_file(const std::string& name_or_path);
std::filesystem::path find_study_file(const std::string& name_or_path);

}  // namespace sightline
