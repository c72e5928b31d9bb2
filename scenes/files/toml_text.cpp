// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/files/toml_text.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <system_error>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

// The length of the quoted text that begins here, its quotes included; 0 where none does.
size_t quoted_length(std::string_view toml) {
  const char quote = toml.front();
  if (quote != '"' && quote != '\'') return 0;
  const std::string three(3, quote);
  const std::string end = toml.starts_with(three) ? three : three.substr(0, 1);
  for (size_t i = end.size(); i < toml.size(); ++i) {
    if (quote == '"' && toml[i] == '\\') {
      ++i;
    } else if (toml.substr(i).starts_with(end)) {
      return i + end.size();
    }
  }
  return toml.size();
}

// The length of the number of twelve decimals or more that begins here; 0 where none does.
size_t long_number_length(std::string_view toml) {
  constexpr size_t kLong = 12;
  const auto digits = [&](size_t begin) {
    size_t end = begin;
    while (end < toml.size() && toml[end] >= '0' && toml[end] <= '9') ++end;
    return end - begin;
  };
  const size_t whole = digits(0);
  if (whole == 0 || whole >= toml.size() || toml[whole] != '.') return 0;
  const size_t decimals = digits(whole + 1);
  if (decimals < kLong) return 0;
  const size_t end = whole + 1 + decimals;
  if (end >= toml.size() || toml[end] != 'e') return end;
  const size_t sign = end + 1 < toml.size() && (toml[end + 1] == '-' || toml[end + 1] == '+');
  const size_t exponent = digits(end + 1 + sign);
  return exponent == 0 ? end : end + 1 + sign + exponent;
}

}  // namespace

std::string toml_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    constexpr unsigned char kDelete = 0x7f;
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (code < ' ' || code == kDelete) {
      out += fmt::format("\\u{:04x}", code);
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::optional<std::string> typed_value(const std::string& typed) {
  try {
    static_cast<void>(toml::parse("value = " + typed));
    return typed;
  } catch (const toml::parse_error&) {
    const bool is_bracketed = (typed.starts_with('[') && typed.ends_with(']')) ||
                              (typed.starts_with('{') && typed.ends_with('}'));
    return is_bracketed ? std::nullopt : std::optional(toml_text(typed));
  }
}

std::string plain_name(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    const auto code = static_cast<unsigned char>(c);
    const bool is_plain = code < 0x80 && (std::isalnum(code) != 0 || c == '-' || c == '.');
    if (!is_plain) c = '_';
  }
  if (out.empty() || out.front() == '.') out.insert(out.begin(), '_');
  return out;
}

std::string with_shortest_numbers(std::string_view toml) {
  std::string out;
  while (!toml.empty()) {
    size_t length = quoted_length(toml);
    double number = 0;
    if (length > 0) {
      out += toml.substr(0, length);
    } else if (length = long_number_length(toml); length > 0) {
      const auto parsed = std::from_chars(toml.data(), toml.data() + length, number);
      out += parsed.ec == std::errc() ? fmt::format("{}", number)
                                      : std::string(toml.substr(0, length));
    } else {
      length = 1;
      out += toml.front();
    }
    toml.remove_prefix(length);
  }
  return out;
}

void require_shallow_keys(std::string_view toml, const std::filesystem::path& name) {
  constexpr int kMostDots = 64;
  int dots = 0;
  int line = 1;
  while (!toml.empty()) {
    size_t length = std::max<size_t>(quoted_length(toml), 1);
    const char c = toml.front();
    if (c == '#') length = std::min(toml.find('\n'), toml.size());
    if (c == '.') ++dots;
    if (std::string_view("\n=,[]{}#").find(c) != std::string_view::npos) dots = 0;
    if (dots > kMostDots) {
      throw InputError(
          fmt::format("{}:{}: a key has over {} parts", name.string(), line, kMostDots + 1));
    }
    line += static_cast<int>(std::count(toml.begin(), toml.begin() + length, '\n'));
    toml.remove_prefix(length);
  }
}

}  // namespace sightline
