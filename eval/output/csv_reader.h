// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/files/toml_table.h"

namespace sightline {

/// Reads somebody's CSV file line by line: a line of column names, then a line a row, fields
/// quoted as RFC 4180 says but none over several lines. Blanks around fields, a byte-order mark and
/// lines without anything in them do not count. Every error is an InputError that names file and
/// line.
class CsvReader {
 public:
  /// Opens the file and reads its first line.
  explicit CsvReader(const std::filesystem::path& file);
  /// The same for a file without column names, which are these: its first line is a row.
  CsvReader(const std::filesystem::path& file, std::vector<std::string> columns);

  const std::vector<std::string>& columns() const { return columns_; }
  bool has_column(std::string_view name) const;
  /// Throws where the file lacks one of these columns or has one that is not among `known`.
  void require_columns(const std::vector<std::string>& required,
                       const std::vector<std::string>& known) const;

  /// Goes on to the next row; false at the file's end.
  bool next();
  int line() const { return line_; }

  // Fields of the row, by the name of their column, which must be there.
  std::string_view text(std::string_view column) const;
  bool is_empty(std::string_view column) const { return text(column).empty(); }
  int whole(std::string_view column) const;    ///< 0 or greater
  int integer(std::string_view column) const;  ///< of any sign
  // The same of what 64 bits hold; from 2^53 on it must stand there in all its digits.
  int64_t wide_whole(std::string_view column) const;
  int64_t wide_integer(std::string_view column) const;
  double number(std::string_view column, Interval allowed = {}) const;  ///< finite
  /// Any number, nan and infinities among them, or what is said of an empty field.
  double number_or(std::string_view column, double if_empty) const;
  /// Exactly so many numbers with spaces between them.
  std::vector<double> numbers(std::string_view column, size_t count) const;
  /// The same where each may be nan or infinite.
  std::vector<double> any_numbers(std::string_view column, size_t count) const;
  /// Names with semicolons between them; none of an empty field.
  std::vector<std::string> names(std::string_view column) const;

  /// Throws an InputError: file, line, reason.
  [[noreturn]] void fail(const std::string& reason) const;

 private:
  bool read_line();

  std::filesystem::path file_;
  std::unique_ptr<std::istream> stream_;
  int line_ = 0;
  std::vector<std::string> columns_;
  std::vector<std::string> fields_;
};

}  // namespace sightline
