// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sightline {

/// True when the path, links followed, lies in the folder or below it.
bool is_inside(const std::filesystem::path& folder, const std::filesystem::path& path);

/// The bytes of a regular file; none where it cannot be read.
std::optional<std::string> whole_file(const std::filesystem::path& file);

/// Where the files that a mesh names may lie: in the folder of its path or below it and, where that
/// path is a symbolic link, in the folder that it leads to. A link that lies there itself may lead
/// anywhere, to one regular file, as caches of models and data lay them. Paths that leave the
/// folders by "..", an absolute path or a linked folder name nothing.
class MeshFolder {
 public:
  explicit MeshFolder(const std::filesystem::path& mesh_file);

  const std::filesystem::path& path() const { return folders_.front(); }

  /// The regular file that is meant by a path, which is absolute or begins at the folder; none
  /// where there is none, or it may not be read.
  std::optional<std::filesystem::path> find(const std::filesystem::path& named) const;
  /// True where that path leads to a regular file that may not be read.
  bool is_outside(const std::filesystem::path& named) const;

 private:
  bool may_read(const std::filesystem::path& file) const;

  std::vector<std::filesystem::path> folders_;
};

}  // namespace sightline
