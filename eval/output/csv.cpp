// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/csv.h"

#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "eval/output/numbers.h"

namespace sightline {

bool seems_formula(std::string_view text) {
  if (text.empty() || std::string_view("=+-@\t").find(text[0]) == std::string_view::npos)
    return false;
  const bool is_below_zero =
      text[0] == '-' && text.size() > 1 && (text[1] == '.' || (text[1] >= '0' && text[1] <= '9'));
  return !is_below_zero && !parsed_number(text);
}

CsvLine& CsvLine::operator<<(std::string_view text) {
  begin_field();
  if (seems_formula(text)) text_ += '\'';
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    text_ += text;
    return *this;
  }
  text_ += '"';
  for (const char c : text) {
    if (c == '"') text_ += '"';
    text_ += c;
  }
  text_ += '"';
  return *this;
}

CsvLine& CsvLine::operator<<(double number) {
  begin_field();
  fmt::format_to(std::back_inserter(text_), "{}", number);
  return *this;
}

CsvLine& CsvLine::operator<<(int64_t number) {
  begin_field();
  fmt::format_to(std::back_inserter(text_), "{}", number);
  return *this;
}

CsvLine& CsvLine::empty_fields(size_t count) {
  for (size_t i = 0; i < count; ++i) *this << "";
  return *this;
}

std::string CsvLine::end() && {
  return std::move(text_) + "\n";
}

void CsvLine::begin_field() {
  if (has_fields_) text_ += ',';
  has_fields_ = true;
}

}  // namespace sightline
