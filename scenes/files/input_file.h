// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The one way to open a file of somebody's: only a regular file (a pipe or a device would never
// end), and none that is larger than what it can sensibly be.
#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <memory>
#include <optional>
#include <string>

namespace sightline {

inline constexpr uintmax_t kMostInputBytes = uintmax_t{1} << 30;  ///< of tables, lists and JSON
inline constexpr uintmax_t kMostTextBytes = uintmax_t{1} << 24;   ///< of what people write by hand
inline constexpr uintmax_t kMostModelBytes = uintmax_t{1} << 32;  ///< of meshes

/// The file's bytes, unpacked while they are read where gzip packed them, whatever its name. Throws
/// InputError, with the file, where it is missing, no regular file, larger than that, or cannot be
/// read; so does the stream where what it unpacks is damaged or becomes larger than that.
std::unique_ptr<std::istream> open_input_file(const std::filesystem::path& file,
                                              uintmax_t most_bytes);

/// The file itself or, where it is missing and one of its name with ".gz" behind is there, that.
std::filesystem::path plain_or_packed(const std::filesystem::path& file);

/// The file's name without the ".gz" that a packed one has behind its own ending.
std::filesystem::path unpacked_name(const std::filesystem::path& file);

/// That name's ending in lower case, with its dot.
std::string input_ending(const std::filesystem::path& file);

/// The bytes of what that opens.
std::string read_input_file(const std::filesystem::path& file, uintmax_t most_bytes);

/// The bytes of a file as they stand, packed or not: for those whose form is checked elsewhere.
/// None where it is missing, no regular file, larger than that, or cannot be read.
std::optional<std::string> bytes_of_file(const std::filesystem::path& file, uintmax_t most_bytes);

/// Its first bytes, at most that many; empty where it is missing, no regular file, or cannot be
/// read.
std::string head_of_file(const std::filesystem::path& file, size_t most_bytes);

inline constexpr size_t kLongestLine = size_t{1} << 20;  ///< bytes

/// As std::getline, but a line ends with CR and with CR LF as well, and no more of it is read than
/// kLongestLine and one byte, which is how a longer one is known.
bool read_bounded_line(std::istream& stream, std::string& line);

}  // namespace sightline
