// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"
#include "scenes/files/pauses.h"

namespace sightline {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

// What Python's json writes for numbers that JSON has not.
constexpr std::array<std::string_view, 3> kNoNumbers = {"-Infinity", "Infinity", "NaN"};

// The text with null for each of kNoNumbers that stands outside of a string.
std::string with_null_for_no_numbers(std::string text) {
  const std::string_view all = text;
  if (all.find("NaN") == all.npos && all.find("Infinity") == all.npos) return text;
  std::string out;
  bool is_in_string = false;
  for (size_t i = 0; i < all.size();) {
    const bool is_escaped = is_in_string && all[i] == '\\';
    if (all[i] == '"') is_in_string = !is_in_string;
    const auto word = std::find_if(kNoNumbers.begin(), kNoNumbers.end(), [&](std::string_view w) {
      return all.substr(i, w.size()) == w;
    });
    const bool is_word = !is_in_string && word != kNoNumbers.end();
    const size_t length = is_word ? word->size() : (is_escaped ? 2 : 1);
    out += is_word ? "null" : all.substr(i, length);
    i += length;
  }
  return out;
}

// Where in a text its byte, counted from 1, stands.
std::string place_of(std::string_view text, size_t byte) {
  const std::string_view before = text.substr(0, byte > 0 ? byte - 1 : 0);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const size_t line_break = before.rfind('\n');
  const size_t column = before.size() - (line_break == before.npos ? 0 : line_break + 1) + 1;
  return fmt::format("line {}, column {}", line, column);
}

[[noreturn]] void fail_as_no_format(const std::string& name, const std::string& why) {
  throw InputError(fmt::format("{}: is not as its format has it: {}", name, why));
}

// The numbers of an array, and of the arrays in it; of null NaN.
void append_numbers(const Json& json, const std::string& key, std::vector<double>& numbers) {
  for (const Json& value : json) {
    if (value.is_array()) {
      append_numbers(value, key, numbers);
    } else if (value.is_number()) {
      numbers.push_back(value.get<double>());
    } else if (value.is_null()) {
      numbers.push_back(std::numeric_limits<double>::quiet_NaN());
    } else {
      throw InputError(fmt::format("{} has {} among its numbers", key, value.dump().substr(0, 40)));
    }
  }
}

[[noreturn]] void fail_as_no(const char* kind, const std::string& key, const Json& value) {
  const std::string given = value.is_null() ? "null or NaN" : value.dump().substr(0, 40);
  throw InputError(fmt::format("{} is {}, must be {}", key, given, kind));
}

// 3.0 is whole as well, as Python takes it.
double whole_double(const std::string& key, const Json& value) {
  const double number =
      value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
  if (number != std::trunc(number)) fail_as_no("a whole number", key, value);
  return number;
}

std::vector<double> numbers_of(const Json& array, const std::string& what, size_t count) {
  if (!array.is_array()) fail_as_no("a list of numbers", what, array);
  std::vector<double> numbers;
  append_numbers(array, what, numbers);
  if (numbers.size() == count) return numbers;
  throw InputError(fmt::format("{} has {} numbers, must have {}", what, numbers.size(), count));
}

}  // namespace

std::string words_of(const Json::exception& problem) {
  constexpr int kNoSuchKey = 403;
  const std::string_view text = problem.what();
  const size_t begin = text.find('\'');
  const size_t end = text.rfind('\'');
  if (problem.id == kNoSuchKey && begin < end) {
    return fmt::format("has no '{}'", text.substr(begin + 1, end - begin - 1));
  }
  constexpr int kNoSuchElement = 401;
  if (problem.id == kNoSuchElement) return "has a list that is too short";
  constexpr std::string_view kMust = "type must be ";
  constexpr std::string_view kIs = ", but is ";
  const size_t must = text.find(kMust);
  const size_t is = text.find(kIs);
  if (must == text.npos || is == text.npos || is < must) return "has a value of another kind";
  const size_t from = must + kMust.size();
  return fmt::format("has {} where {} must stand", text.substr(is + kIs.size()),
                     text.substr(from, is - from));
}

Json parse_json(std::string text, const std::string& name, const JsonBounds& bounds) {
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  text = with_null_for_no_numbers(std::move(text));
  int lists = 0, values = 0;
  const auto check_bounds = [&](int depth, Json::parse_event_t event, const Json&) {
    pause_at_times();
    if (depth > bounds.deepest) {
      throw InputError(fmt::format("{}: is nested deeper than {}", name, bounds.deepest));
    }
    using Event = Json::parse_event_t;
    lists += event == Event::array_start || event == Event::object_start;
    values += event == Event::value;
    if (lists > bounds.most_lists) {
      throw InputError(
          fmt::format("{}: has more than {} lists and objects", name, bounds.most_lists));
    }
    if (values <= bounds.most_values) return true;
    throw InputError(fmt::format("{}: has more than {} values", name, bounds.most_values));
  };
  try {
    return Json::parse(text, check_bounds);
  } catch (const Json::parse_error& problem) {
    fail_as_no_format(name, fmt::format("is no JSON at {}", place_of(text, problem.byte)));
  } catch (const Json::exception& problem) {  // a number that no double holds
    fail_as_no_format(name, "is no JSON, or has a number that is too large");
  }
}

Json read_json(const std::filesystem::path& file) {
  return parse_json(read_input_file(file, kMostInputBytes), file.string());
}

std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void with_json(const std::filesystem::path& file, const std::function<void(const Json&)>& use) {
  const Json json = read_json(file);
  try {
    use(json);
  } catch (const Json::exception& error) {
    fail_as_no_format(file.string(), words_of(error));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
}

std::string first_key_in(const Json& json, std::span<const char* const> keys) {
  const auto found = std::find_if(keys.begin(), keys.end(), [&json](const char* key) {
    return json.is_object() && json.contains(key);
  });
  return found == keys.end() ? keys.front() : *found;
}

const Json& value_in(const Json& json, const std::string& key) {
  if (!json.is_object()) {
    throw InputError(
        fmt::format("has {} where an object with '{}' must stand", json.dump().substr(0, 40), key));
  }
  const auto found = json.find(key);
  if (found == json.end())
    throw InputError(fmt::format("is not as its format has it: has no '{}'", key));
  return *found;
}

int whole_in(const Json& json, const std::string& key) {
  const Json& value = value_in(json, key);
  constexpr int kMost = std::numeric_limits<int>::max();
  const double number = whole_double(key, value);
  if (std::abs(number) > kMost) fail_as_no("a whole number below 2^31", key, value);
  return static_cast<int>(number);
}

int64_t wide_whole_in(const Json& json, const std::string& key) {
  const Json& value = value_in(json, key);
  constexpr double kExact = 0x1p53;  // below it a double is one whole number and no other
  constexpr double kTooLarge = 0x1p63;
  constexpr uint64_t kMost = std::numeric_limits<int64_t>::max();
  const double number = whole_double(key, value);
  const bool is_held = value.is_number_unsigned()
                           ? value.get<uint64_t>() <= kMost
                           : value.is_number_integer() || std::abs(number) < kTooLarge;
  if (!is_held) fail_as_no("a whole number below 2^63", key, value);
  if (value.is_number_integer()) return value.get<int64_t>();
  if (std::abs(number) >= kExact) fail_as_no("a whole number in all its digits", key, value);
  return static_cast<int64_t>(number);
}

double number_in(const Json& json, const std::string& key) {
  const Json& value = value_in(json, key);
  if (!value.is_number() || !std::isfinite(value.get<double>())) fail_as_no("a number", key, value);
  return value.get<double>();
}

std::string text_in(const Json& json, const std::string& key) {
  const Json& value = value_in(json, key);
  if (!value.is_string()) fail_as_no("a text", key, value);
  return value.get<std::string>();
}

std::vector<double> numbers_or_nan_in(const Json& json, const std::string& key, size_t count) {
  return numbers_of(value_in(json, key), key, count);
}

std::vector<double> finite_numbers(const Json& array, const std::string& what, size_t count) {
  std::vector<double> numbers = numbers_of(array, what, count);
  const bool is_finite = std::all_of(numbers.begin(), numbers.end(),
                                     [](double value) { return std::isfinite(value); });
  if (is_finite) return numbers;
  throw InputError(fmt::format("{} has what is no finite number", what));
}

std::vector<double> numbers_in(const Json& json, const std::string& key, size_t count) {
  return finite_numbers(value_in(json, key), key, count);
}

}  // namespace sightline
