// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/files/input_file.h"

#include <system_error>

#include <fmt/format.h>

#include "scenes/files/input_error.h"

namespace sightline {

std::ifstream open_input_file(const std::filesystem::path& file, uintmax_t most_bytes) {
  std::error_code error;
  std::ifstream stream;
  if (std::filesystem::is_regular_file(file, error)) stream.open(file, std::ios::binary);
  if (!stream.is_open()) {
    throw InputError(fmt::format("{}: is missing or cannot be read", file.string()));
  }
  const uintmax_t size = std::filesystem::file_size(file, error);
  if (error || size > most_bytes) {
    throw InputError(
        fmt::format("{}: is larger than {} MiB", file.string(), most_bytes / (1024 * 1024)));
  }
  return stream;
}

std::string read_input_file(const std::filesystem::path& file, uintmax_t most_bytes) {
  std::ifstream stream = open_input_file(file, most_bytes);
  std::string bytes(std::filesystem::file_size(file), '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<size_t>(stream.gcount()));
  return bytes;
}

bool read_bounded_line(std::istream& stream, std::string& line) {
  line.clear();
  std::streambuf& buffer = *stream.rdbuf();
  constexpr int kEnd = std::char_traits<char>::eof();
  for (int next = buffer.sbumpc(); next != kEnd; next = buffer.sbumpc()) {
    if (next == '\n') return true;
    line += static_cast<char>(next);
    if (line.size() > kLongestLine) return true;
  }
  stream.setstate(std::ios::eofbit);
  return !line.empty();
}

}  // namespace sightline
