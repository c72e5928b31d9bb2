// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/solve/number_rows.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "eval/output/numbers.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace {

constexpr std::string_view kSeparators = ",; \t\r";

std::vector<std::string_view> words_in(std::string_view line) {
  std::vector<std::string_view> words;
  size_t begin = line.find_first_not_of(kSeparators);
  while (begin != std::string_view::npos) {
    const size_t end = std::min(line.find_first_of(kSeparators, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kSeparators, end);
  }
  return words;
}

}  // namespace

std::vector<std::vector<double>> read_number_rows(const std::filesystem::path& file, size_t least,
                                                  size_t most, const std::string& what) {
  const auto stream = open_input_file(file, kMostInputBytes);
  std::vector<std::vector<double>> rows;
  std::string line;
  for (int number = 1; read_bounded_line(*stream, line); ++number) {
    const auto fail = [&](const std::string& reason) {
      throw InputError(
          fmt::format("{}: line {} {}, must have {}", file.string(), number, reason, what));
    };
    if (line.size() > kLongestLine) fail(fmt::format("is longer than {} bytes", kLongestLine));
    if (line.find('\0') != std::string::npos) fail("has a byte of value 0, which no text has");
    const std::vector<std::string_view> words = words_in(line);
    if (words.empty() || words.front().starts_with('#')) continue;
    if (rows.empty() && !parsed_number(words.front())) continue;  // the names of the columns
    std::vector<double>& row = rows.emplace_back();
    for (const std::string_view word : words) {
      const auto value = parsed_number(word);
      if (!value) fail(fmt::format("has '{}'", word));
      row.push_back(*value);
    }
    if (row.size() < least || row.size() > most || row.size() != rows.front().size()) {
      fail(fmt::format("has {} numbers", row.size()));
    }
  }
  if (rows.empty()) throw InputError(fmt::format("{}: has no rows of numbers", file.string()));
  return rows;
}

}  // namespace sightline
