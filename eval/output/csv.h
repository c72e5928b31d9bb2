// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace sightline {

/// Whether a spreadsheet takes a text for a formula, which it would run: it begins with =, +, - or
/// @ (or a tab, which is dropped) and is no number, nor begins like one below zero.
bool seems_formula(std::string_view text);

/// A line of a CSV file, to which `<<` adds the fields one by one: texts quoted where they have to
/// be (RFC 4180) and with an apostrophe before what seems a formula, numbers as the shortest that
/// read back the same.
class CsvLine {
 public:
  CsvLine& operator<<(std::string_view text);
  CsvLine& operator<<(double number);
  CsvLine& operator<<(int64_t number);
  CsvLine& operator<<(int number) { return *this << int64_t{number}; }

  CsvLine& empty_fields(size_t count);

  /// The whole line with its end; nothing can be added after it.
  std::string end() &&;

 private:
  void begin_field();

  std::string text_;
  bool has_fields_ = false;
};

}  // namespace sightline
