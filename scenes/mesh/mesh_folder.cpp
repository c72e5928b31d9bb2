// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/mesh_folder.h"

#include <algorithm>
#include <system_error>

#include "scenes/files/input_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

}  // namespace

bool is_inside(const fs::path& folder, const fs::path& path) {
  std::error_code error;
  const auto within = fs::weakly_canonical(folder, error);
  if (error) return false;
  const auto real = fs::weakly_canonical(path, error);
  if (error) return false;
  const auto [rest, unused] = std::mismatch(within.begin(), within.end(), real.begin(), real.end());
  return rest == within.end();
}

std::optional<std::string> whole_file(const std::filesystem::path& file) {
  return bytes_of_file(file, kMostModelBytes);
}

MeshFolder::MeshFolder(const fs::path& mesh_file)
    : folders_{fs::absolute(mesh_file).lexically_normal().parent_path()} {
  std::error_code error;
  const fs::path real = fs::canonical(mesh_file, error);
  if (!error && real.parent_path() != folders_.front()) folders_.push_back(real.parent_path());
}

std::optional<fs::path> MeshFolder::find(const fs::path& named) const {
  const fs::path given = (folders_.front() / named).lexically_normal();
  const fs::path beside = given.lexically_relative(folders_.front());
  for (const fs::path& folder : folders_) {
    std::error_code error;
    const bool is_below = !beside.empty() && *beside.begin() != "..";
    const fs::path file = is_below ? folder / beside : given;
    if (fs::is_regular_file(file, error) && may_read(file)) return file;
  }
  return std::nullopt;
}

bool MeshFolder::is_outside(const fs::path& named) const {
  std::error_code error;
  const fs::path given = (folders_.front() / named).lexically_normal();
  return fs::is_regular_file(given, error) && !find(named);
}

bool MeshFolder::may_read(const fs::path& file) const {
  std::error_code error;
  const bool is_link = fs::is_symlink(file, error);
  return std::any_of(folders_.begin(), folders_.end(), [&](const fs::path& folder) {
    return is_inside(folder, file) || (is_link && is_inside(folder, file.parent_path()));
  });
}

}  // namespace sightline
