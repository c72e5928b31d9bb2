// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Keys that name a folder, one of whose files is drawn for each frame.
#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/scene/keys.h"

namespace sightline {

/// The files of such a folder; none of them where the key names no folder.
struct FileDraw {
  std::string key;                           ///< "scene.toml: environment.file", for errors
  std::string given;                         ///< the folder, as the file has it
  std::vector<std::filesystem::path> files;  ///< by name: a draw is the same on every machine

  bool is_there() const { return !files.empty(); }
  const std::filesystem::path& draw(RandomStream& stream) const;
  /// A file of it, as the truth states it: the folder as it was given, and the name.
  std::string stated(const std::filesystem::path& file) const;
  /// Throws InputError; `problem` is to stand after the name of one of the files.
  [[noreturn]] void fail(const std::filesystem::path& file, std::string_view problem) const;
};

/// Files of such folders that can be read.
using CheckedFiles = std::set<std::filesystem::path>;

/// What a key names: a path beside the file that the table is of or, where there is no such, as it
/// stands.
std::filesystem::path named_path(const TomlTable& table, std::string_view given);

/// The files of the folder at `found` that `is_one` takes, for the key of that table, under which
/// `given` stands. Throws InputError, saying which `kind` of file it has none of.
FileDraw files_of(const TomlTable& table, const std::string& table_name, std::string_view key,
                  const std::filesystem::path& found, const std::string& given,
                  const std::function<bool(const std::filesystem::path&)>& is_one,
                  std::string_view kind);

}  // namespace sightline
