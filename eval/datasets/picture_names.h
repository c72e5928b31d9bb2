// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace sightline {

/// Pictures of a set by the names that files of others have for them: with all their folders, some
/// or none, or more than are known here, as long as one picture alone is called so.
class PictureNames {
 public:
  /// A picture's path and what it stands for, from 0.
  void add(const std::filesystem::path& picture, int id);

  /// What the picture of a name stands for: the one whose path ends with it, or with whose whole
  /// path it ends; none where there is no such, as with another set's folder. Throws InputError,
  /// with `where` the name stands, where there are several.
  std::optional<int> find(const std::string& name, const std::string& where) const;

  bool empty() const { return by_end_.empty(); }

 private:
  std::map<std::string, int> by_end_;   ///< of a path; kSeveral where it is several pictures'
  std::map<std::string, int> by_path_;  ///< whole; the same
};

}  // namespace sightline
