// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace sightline {

/// The numbers a key accepts, ends included.
struct Interval {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

/// The strict way to read a TOML file: every value is checked at the door, every error is an
/// InputError that names the file, the key, what was given and what is allowed, and
/// `reject_unknown_keys` turns a key that nobody asked for into an error. A getter without fallback
/// requires the key.
class TomlTable {
 public:
  /// Reads a file, then sets each override "a.b=value" (value in TOML; a bare word is a string;
  /// "a.0.b" is a key of the first table of an array).
  static TomlTable read_file(const std::filesystem::path& file,
                             std::span<const std::string> overrides = {});

  /// The same for a text; `name` stands for the file in errors.
  static TomlTable read_text(const std::string& text, const std::filesystem::path& name,
                             std::span<const std::string> overrides = {});

  bool has(std::string_view key) const;
  /// True where the key holds an array, be it of values or of tables.
  bool is_array(std::string_view key) const;
  /// True where the key holds a text.
  bool is_text(std::string_view key) const;
  /// All keys of this table, in alphabetical order. They count as known.
  std::vector<std::string> keys() const;

  double number(std::string_view key, Interval allowed = {},
                std::optional<double> fallback = {}) const;
  /// A number, or [low, high]; both ends within `allowed`. One number is an interval of no width.
  Interval number_or_range(std::string_view key, Interval allowed, double fallback) const;
  int64_t integer(std::string_view key, Interval allowed = {},
                  std::optional<int64_t> fallback = {}) const;
  bool flag(std::string_view key, std::optional<bool> fallback = {}) const;
  std::string text(std::string_view key, std::optional<std::string> fallback = {}) const;
  /// A text that must be one of `allowed`; the error suggests the nearest.
  std::string choice(std::string_view key, std::span<const std::string> allowed,
                     std::optional<std::string> fallback = {}) const;
  std::vector<std::string> texts(std::string_view key,
                                 std::optional<std::vector<std::string>> fallback = {}) const;
  /// An array of exactly `count` finite numbers.
  std::vector<double> numbers(std::string_view key, size_t count,
                              std::optional<std::vector<double>> fallback = {}) const;
  /// The same where several counts are allowed.
  std::vector<double> numbers(std::string_view key, std::span<const size_t> counts) const;
  /// An array of one or more numbers, each within `allowed` and none twice.
  std::vector<double> number_list(std::string_view key, Interval allowed) const;
  /// The values of an array of one or more numbers, texts, flags or arrays of numbers, none twice,
  /// each as TOML writes it.
  std::vector<std::string> literals(std::string_view key) const;
  Eigen::Vector3d vector3(std::string_view key, std::optional<Eigen::Vector3d> fallback = {}) const;
  /// An array of arrays of points, each an array of three numbers: shape `least_outer` or more x
  /// `inner` x 3.
  std::vector<std::vector<Eigen::Vector3d>> point_lists(std::string_view key, size_t least_outer,
                                                        size_t inner) const;

  /// The sub-table of that name; empty when absent.
  TomlTable table(std::string_view key) const;
  /// The tables of an array of tables; none when absent.
  std::vector<TomlTable> tables(std::string_view key) const;

  /// Throws for the first key, here or in sub-tables that were asked for, that no getter has named.
  void reject_unknown_keys() const;

  /// Throws InputError "<file>: <key>: <message>".
  [[noreturn]] void fail(std::string_view key, const std::string& message) const;

  const std::filesystem::path& file() const;
  /// The whole file as TOML, overrides applied.
  std::string to_toml() const;
  /// Every value of this table and of those within it, as TOML writes it, by the path of its key as
  /// overrides have it: "a.b", "a.0.b" in an array of tables. They do not count as known.
  std::map<std::string, std::string> values() const;

 private:
  struct Document;
  struct Node;
  explicit TomlTable(std::shared_ptr<const Node> node) : node_(std::move(node)) {}

  std::shared_ptr<const Node> node_;
};

}  // namespace sightline
