// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The one way to open a file of somebody's: only a regular file (a pipe or a device would never
// end), and none that is larger than what it can sensibly be.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace sightline {

inline constexpr uintmax_t kMostInputBytes = uintmax_t{1} << 30;  ///< of tables, lists and JSON
inline constexpr uintmax_t kMostTextBytes = uintmax_t{1} << 24;   ///< of what people write by hand
inline constexpr uintmax_t kMostModelBytes = uintmax_t{1} << 32;  ///< of meshes

/// Throws InputError, with the file, where it is missing, no regular file, larger than that, or
/// cannot be read.
std::ifstream open_input_file(const std::filesystem::path& file, uintmax_t most_bytes);

/// Its bytes.
std::string read_input_file(const std::filesystem::path& file, uintmax_t most_bytes);

inline constexpr size_t kLongestLine = size_t{1} << 20;  ///< bytes

/// As std::getline, but reads no more of a line than kLongestLine and one byte, which is how a
/// longer one is known.
bool read_bounded_line(std::istream& stream, std::string& line);

}  // namespace sightline
