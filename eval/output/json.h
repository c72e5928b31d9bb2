// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace sightline {

using Json = nlohmann::ordered_json;

/// How much JSON of somebody's may hold. No format that we read is nested that deep: what walks
/// through JSON calls itself. Lists and objects take some ten times their text.
struct JsonBounds {
  int deepest = 100;            ///< arrays and objects within one another
  int most_lists = 10'000'000;  ///< and objects
  int most_values = 50'000'000;
};

/// What a text of somebody's holds, which errors call `name`. A byte-order mark at its beginning
/// does not count, and what Python writes where JSON has no number (NaN, Infinity, -Infinity) is
/// null. Throws InputError where it is no JSON or beyond the bounds.
Json parse_json(std::string text, const std::string& name, const JsonBounds& bounds = {});

/// The same of a file. Throws InputError, with the file, also where it is missing, no regular file
/// (a pipe or a device would never end) or over 1 GiB.
Json read_json(const std::filesystem::path& file);

/// In our words, what a reader misses that asked JSON for more than there is: the library's own
/// texts speak of its types and exceptions.
std::string words_of(const Json::exception& problem);

/// The text of JSON for standard output or a file, indented; bytes that are no UTF-8 are U+FFFD.
std::string json_text(const Json& json);

/// Calls `use` with what read_json gives. Throws InputError, with the file, where it lacks what
/// `use` asks it for.
void with_json(const std::filesystem::path& file, const std::function<void(const Json&)>& use);

// What stands under a key of an object. All throw InputError, with the key, what stands there and
// what must, where it is not so.

/// The first of these keys that the object has; where it has none, the first of them.
std::string first_key_in(const Json& json, std::span<const char* const> keys);
/// The value itself.
const Json& value_in(const Json& json, const std::string& key);
/// A whole number that an int holds.
int whole_in(const Json& json, const std::string& key);
/// One that an int64_t holds; from 2^53 on it must stand there in all its digits, not as 1.7e18.
int64_t wide_whole_in(const Json& json, const std::string& key);
/// A finite number.
double number_in(const Json& json, const std::string& key);
std::string text_in(const Json& json, const std::string& key);
/// So many finite numbers, in an array or in arrays of them, as a matrix may be written.
std::vector<double> numbers_in(const Json& json, const std::string& key, size_t count);
/// The same of the array itself, which errors call `what`.
std::vector<double> finite_numbers(const Json& array, const std::string& what, size_t count);
/// numbers_in where null, which stands for what is no number, is NaN.
std::vector<double> numbers_or_nan_in(const Json& json, const std::string& key, size_t count);

}  // namespace sightline
