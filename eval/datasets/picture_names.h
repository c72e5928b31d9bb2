// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace sightline {

/// Pictures of a set by the names that files of others have for them: with all their folders, some
/// or none, as long as one picture alone is called so.
class PictureNames {
 public:
  /// A picture's path, within the set or not, and what it stands for, from 0.
  void add(const std::filesystem::path& picture, int id);

  /// What the picture of a name stands for: the one whose path has the longest end in common with
  /// it, its file's name at least; none where there is no such. Throws InputError, with `where` the
  /// name stands, where there are several.
  std::optional<int> find(const std::string& name, const std::string& where) const;

  bool empty() const { return by_end_.empty(); }

 private:
  std::map<std::string, int> by_end_;  ///< of a path; kSeveral where it is several pictures'
};

}  // namespace sightline
