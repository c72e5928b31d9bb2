// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/csv_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/csv.h"
#include "eval/output/numbers.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

// What stands in quotes at the beginning of `rest`, which is left behind the closing one. None
// where there is no closing one.
std::optional<std::string> take_quoted(std::string_view& rest) {
  std::string field;
  rest.remove_prefix(1);
  while (true) {
    const size_t quote = rest.find('"');
    if (quote == std::string_view::npos) return std::nullopt;
    field += rest.substr(0, quote);
    rest.remove_prefix(quote + 1);
    if (!rest.starts_with('"')) return field;
    field += '"';
    rest.remove_prefix(1);
  }
}

// None where a quote does not end.
std::optional<std::vector<std::string>> fields_of(std::string_view line) {
  std::vector<std::string> fields;
  while (true) {
    line = trimmed(line);
    std::string field;
    if (line.starts_with('"')) {
      auto quoted = take_quoted(line);
      if (!quoted) return std::nullopt;
      field = std::move(*quoted);
    }
    const size_t comma = line.find(',');
    field += trimmed(line.substr(0, comma));
    if (field.starts_with('\'') && seems_formula(std::string_view(field).substr(1)))
      field.erase(0, 1);
    fields.push_back(std::move(field));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

std::optional<double> finite_number(std::string_view text) {
  const auto value = parsed_number(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

// Of "+3" and "3.0" as well, as others write what is whole. What is not written as digits alone
// has no more of them than a double tells.
std::optional<int64_t> wide_number_of(std::string_view text) {
  constexpr double kExact = 0x1p53;  // below it a double is one whole number and no other
  std::string_view digits = text;
  if (digits.starts_with('+') && !digits.starts_with("+-")) digits.remove_prefix(1);
  int64_t whole = 0;
  const char* const end = digits.data() + digits.size();
  const auto [rest, error] = std::from_chars(digits.data(), end, whole);
  if (error == std::errc() && rest == end) return whole;
  const auto value = finite_number(text);
  const bool is_whole = value && *value == std::trunc(*value) && std::abs(*value) < kExact;
  return is_whole ? std::optional(static_cast<int64_t>(*value)) : std::nullopt;
}

std::optional<int> whole_number_of(std::string_view text) {
  constexpr int kMost = std::numeric_limits<int>::max();
  const auto value = wide_number_of(text);
  const bool is_held = value && *value <= kMost && *value >= -kMost;
  return is_held ? std::optional(static_cast<int>(*value)) : std::nullopt;
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    const size_t end = std::min(text.find_first_of(" \t"), text.size());
    words.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return words;
}

}  // namespace

CsvReader::CsvReader(const std::filesystem::path& file)
    : file_(file), stream_(open_input_file(file, kMostInputBytes)) {
  if (!read_line()) throw InputError(fmt::format("{}: is empty", file.string()));
  columns_ = std::move(fields_);
}

CsvReader::CsvReader(const std::filesystem::path& file, std::vector<std::string> columns)
    : file_(file), stream_(open_input_file(file, kMostInputBytes)), columns_(std::move(columns)) {}

void CsvReader::fail(const std::string& reason) const {
  throw InputError(fmt::format("{}: line {} {}", file_.string(), line_, reason));
}

bool CsvReader::has_column(std::string_view name) const {
  return std::find(columns_.begin(), columns_.end(), name) != columns_.end();
}

void CsvReader::require_columns(const std::vector<std::string>& required,
                                const std::vector<std::string>& known) const {
  for (const std::string& column : required) {
    if (!has_column(column)) {
      fail(fmt::format("names no column '{}', must name {}", column, fmt::join(required, ", ")));
    }
  }
  for (auto column = columns_.begin(); column != columns_.end(); ++column) {
    if (std::find(known.begin(), known.end(), *column) == known.end()) {
      fail(fmt::format("has a column '{}'{}", *column, suggestion(*column, known)));
    }
    if (std::find(columns_.begin(), column, *column) != column) {
      fail(fmt::format("has the column '{}' twice", *column));
    }
  }
}

bool CsvReader::read_line() {
  std::string text;
  while (read_bounded_line(*stream_, text)) {
    ++line_;
    if (text.size() > kLongestLine) {
      fail(fmt::format("is longer than {} bytes", kLongestLine));
    }
    if (text.find('\0') != std::string::npos) {
      fail(
          "has a byte of value 0, which no text has: it may be UTF-16 (save it as UTF-8), or no "
          "CSV");
    }
    std::string_view line = text;
    if (line_ == 1 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
    if (trimmed(line).empty()) continue;
    auto fields = fields_of(line);
    if (!fields) fail("has a quote that does not end");
    fields_ = std::move(*fields);
    return true;
  }
  return false;
}

bool CsvReader::next() {
  if (!read_line()) return false;
  if (fields_.size() == columns_.size()) return true;
  fail(fmt::format("has {} fields, must have {}: {}", fields_.size(), columns_.size(),
                   fmt::join(columns_, ",")));
}

std::string_view CsvReader::text(std::string_view column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  return fields_.at(static_cast<size_t>(found - columns_.begin()));
}

int CsvReader::whole(std::string_view column) const {
  const auto value = whole_number_of(text(column));
  if (value && *value >= 0) return *value;
  fail(fmt::format("has {} '{}', must be a whole number from 0", column, text(column)));
}

int CsvReader::integer(std::string_view column) const {
  const auto value = whole_number_of(text(column));
  if (value) return *value;
  fail(fmt::format("has {} '{}', must be a whole number", column, text(column)));
}

int64_t CsvReader::wide_whole(std::string_view column) const {
  const auto value = wide_number_of(text(column));
  if (value && *value >= 0) return *value;
  fail(fmt::format("has {} '{}', must be a whole number from 0", column, text(column)));
}

int64_t CsvReader::wide_integer(std::string_view column) const {
  const auto value = wide_number_of(text(column));
  if (value) return *value;
  const auto number = finite_number(text(column));
  const bool is_whole = number && *number == std::trunc(*number);
  fail(fmt::format("has {} '{}', must be a whole number{}", column, text(column),
                   is_whole ? " below 2^63 in all its digits" : ""));
}

double CsvReader::number_or(std::string_view column, double if_empty) const {
  if (is_empty(column)) return if_empty;
  const auto value = parsed_number(text(column));
  if (value) return *value;
  fail(fmt::format("has '{}' for {}, must be a number", text(column), column));
}

double CsvReader::number(std::string_view column, Interval allowed) const {
  const auto value = finite_number(text(column));
  if (!value) {
    fail(fmt::format("has '{}' for {}, must be a finite number", text(column), column));
  }
  if (*value < allowed.min || *value > allowed.max) {
    fail(fmt::format("has {} for {}, must be from {} to {}", *value, column, allowed.min,
                     allowed.max));
  }
  return *value;
}

std::vector<double> CsvReader::any_numbers(std::string_view column, size_t count) const {
  const std::vector<std::string_view> words = words_of(text(column));
  if (words.size() != count) {
    fail(fmt::format("has {} numbers for {}, must have {} with spaces between them", words.size(),
                     column, count));
  }
  std::vector<double> values;
  for (const std::string_view word : words) {
    const auto value = parsed_number(word);
    if (!value) fail(fmt::format("has '{}' for {}, must be a number", word, column));
    values.push_back(*value);
  }
  return values;
}

std::vector<double> CsvReader::numbers(std::string_view column, size_t count) const {
  std::vector<double> values = any_numbers(column, count);
  for (const double value : values) {
    if (!std::isfinite(value)) {
      fail(fmt::format("has '{}' for {}, must be a finite number", value, column));
    }
  }
  return values;
}

std::vector<std::string> CsvReader::names(std::string_view column) const {
  std::vector<std::string> names;
  for (std::string_view rest = text(column); !rest.empty();) {
    const size_t end = std::min(rest.find(';'), rest.size());
    if (end > 0) names.emplace_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return names;
}

}  // namespace sightline
