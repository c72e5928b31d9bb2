// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/files/assets.h"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

fs::path folder_to_use;  // empty: none was named

bool is_path(const std::string& text) {
  return text.find('/') != std::string::npos || fs::path(text).has_extension();
}

fs::path find_by_name(const std::string& name, const char* kind,
                      const std::vector<std::string>& names, const fs::path& file) {
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    throw InputError(fmt::format("{} '{}' is not known{}", kind, name, suggestion(name, names)));
  }
  return file;
}

}  // namespace

fs::path assets_folder() {
  std::error_code error;
  if (const char* folder = std::getenv("SIGHTLINE_ASSETS")) {
    if (fs::is_directory(fs::path(folder) / "targets", error)) return folder;
    throw InputError(fmt::format("SIGHTLINE_ASSETS={}: is no folder with targets", folder));
  }
  if (!folder_to_use.empty()) return folder_to_use;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = program.parent_path().parent_path() / "share" / "sightline";
  if (!error && fs::is_directory(installed / "targets", error)) return installed;
  return SIGHTLINE_ASSETS_DIR;
}

void use_assets(const fs::path& folder) {
  folder_to_use = folder;
}

std::vector<std::string> target_names() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(assets_folder() / "targets", error)) {
    if (fs::exists(entry.path() / "target.toml")) names.push_back(entry.path().filename());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> study_names() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(assets_folder() / "studies", error)) {
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem());
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path find_target_file(const std::string& name_or_path) {
  if (is_path(name_or_path)) return name_or_path;
  return find_by_name(name_or_path, "target", target_names(),
                      assets_folder() / "targets" / name_or_path / "target.toml");
}

fs::path find_study_file(const std::string& name_or_path) {
  if (is_path(name_or_path)) return name_or_path;
  return find_by_name(name_or_path, "study", study_names(),
                      assets_folder() / "studies" / (name_or_path + ".toml"));
}

}  // namespace sightline
