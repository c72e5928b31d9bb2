// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string_view>

namespace sightline {

/// An output folder that appears whole or not at all: files are written to a folder beside it,
/// ".NAME.partial", which takes its name on commit() and is removed if that never comes. A lock
/// that ends with the process, however it ends, keeps a second run out of it.
class OutputFolder {
 public:
  /// What a process that was killed left in the folder beside.
  enum class Leftovers { kRemove, kKeep };

  /// Throws InputError when `folder` exists and is not empty, cannot be written, or when another
  /// process is writing it.
  explicit OutputFolder(const std::filesystem::path& folder,
                        Leftovers leftovers = Leftovers::kRemove);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where a file of the folder lies until commit().
  std::filesystem::path operator/(std::string_view file) const { return staging_ / file; }
  /// The folder beside, where all files lie until commit().
  const std::filesystem::path& staging() const { return staging_; }

  /// Removes what is there, the leftovers of others as well.
  void clear();
  /// Without a commit() to come, what has been written stays for another run to continue.
  void keep(bool is_kept = true) { is_kept_ = is_kept; }
  void commit();

 private:
  void remove_all();
  void remove_empty_parents();

  std::filesystem::path folder_;
  std::filesystem::path staging_;
  std::filesystem::path made_parent_;  ///< the topmost parent that had to be made; may be empty
  int lock_ = -1;
  bool is_kept_ = false;
  bool is_committed_ = false;
};

/// Where the files of an output folder lie until it is whole.
std::filesystem::path staging_folder(const std::filesystem::path& folder);

/// Writes a whole file or throws InputError: the text goes to a file beside it that then takes its
/// name.
void write_file(const std::filesystem::path& file, std::string_view text);
/// The same of a text that `write` makes piece by piece.
void write_file(const std::filesystem::path& file, const std::function<void(std::ostream&)>& write);

}  // namespace sightline
