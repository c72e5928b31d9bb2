// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string_view>

namespace sightline {

/// An output folder that appears whole or not at all: files are written to a folder beside it,
/// which takes its name on commit() and is removed if that never comes.
class OutputFolder {
 public:
  /// Throws InputError when `folder` exists and is not empty, or cannot be written.
  explicit OutputFolder(const std::filesystem::path& folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where a file of the folder lies until commit().
  std::filesystem::path operator/(std::string_view file) const { return staging_ / file; }

  void commit();

 private:
  void remove_all();

  std::filesystem::path folder_;
  std::filesystem::path staging_;
  std::filesystem::path made_parent_;  ///< the topmost parent that had to be made; may be empty
  bool is_committed_ = false;
};

/// Writes a whole file or throws InputError: the text goes to a file beside it that then takes its
/// name.
void write_file(const std::filesystem::path& file, std::string_view text);

}  // namespace sightline
