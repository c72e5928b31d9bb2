// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/plain_text.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr std::string_view kReplacement = "\uFFFD";
constexpr unsigned char kDelete = 0x7f;

// How many bytes of a well-formed character stand at the beginning of the text; 0: none does
// (RFC 3629: no overlong forms, no surrogates, nothing beyond U+10FFFF).
size_t character_length(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  const auto continues = [&](size_t i) { return i < text.size() && (byte(i) & 0xC0) == 0x80; };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first < 0xE0) return continues(1) ? 2 : 0;
  if (first >= 0xE0 && first < 0xF0) {
    if (!continues(1) || !continues(2)) return 0;
    const bool is_overlong = first == 0xE0 && byte(1) < 0xA0;
    const bool is_surrogate = first == 0xED && byte(1) >= 0xA0;
    return is_overlong || is_surrogate ? 0 : 3;
  }
  if (first >= 0xF0 && first < 0xF5) {
    if (!continues(1) || !continues(2) || !continues(3)) return 0;
    const bool is_overlong = first == 0xF0 && byte(1) < 0x90;
    const bool is_beyond = first == 0xF4 && byte(1) >= 0x90;
    return is_overlong || is_beyond ? 0 : 4;
  }
  return 0;
}

// The picture of a control character of ASCII: U+2400 and on, U+2421 for DEL.
std::string picture_of(unsigned char control) {
  const int code = control == kDelete ? 0x21 : control;
  return {'\xE2', '\x90', static_cast<char>(0x80 + code)};
}

// U+0080 to U+009F, and the ends of lines and paragraphs beyond ASCII.
bool is_control_beyond_ascii(std::string_view character) {
  const bool is_c1 = character.size() == 2 && character[0] == '\xC2' &&
                     static_cast<unsigned char>(character[1]) < 0xA0;
  return is_c1 || character == "\u2028" || character == "\u2029";
}

std::string without_controls(std::string_view text, std::string_view kept) {
  std::string out;
  while (!text.empty()) {
    const size_t length = character_length(text);
    const std::string_view character = text.substr(0, std::max<size_t>(length, 1));
    const auto first = static_cast<unsigned char>(text.front());
    if (length == 0 || is_control_beyond_ascii(character)) {
      out += kReplacement;
    } else if ((first < ' ' || first == kDelete) &&
               kept.find(text.front()) == std::string_view::npos) {
      out += picture_of(first);
    } else {
      out += character;
    }
    text.remove_prefix(character.size());
  }
  return out;
}

bool is_plain_in_shell(char c) {
  constexpr std::string_view kOthers = "_./=,:+@%-";
  const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  return is_letter || (c >= '0' && c <= '9') || kOthers.find(c) != std::string_view::npos;
}

// Whether a character beside digits says that they are of a name, as of a file.
bool is_of_name(char c) {
  return c == '/' || c == '_' || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

// The text without the middle of numbers that nobody reads to their end.
std::string with_short_numbers(std::string_view text) {
  constexpr size_t kLongest = 40;
  constexpr size_t kKept = 12;
  constexpr std::string_view kDigits = "0123456789";
  std::string out;
  while (!text.empty()) {
    const size_t others = std::min(text.find_first_of(kDigits), text.size());
    out += text.substr(0, others);
    text.remove_prefix(others);
    const size_t digits = std::min(text.find_first_not_of(kDigits), text.size());
    const bool is_named = (!out.empty() && is_of_name(out.back())) ||
                          (digits < text.size() && is_of_name(text[digits]));
    const bool is_long = digits > kLongest && !is_named;
    out += text.substr(0, is_long ? kKept : digits);
    if (is_long) out += "... (" + std::to_string(digits) + " digits)";
    text.remove_prefix(digits);
  }
  return out;
}

}  // namespace

std::string plain_line(std::string_view text) {
  return without_controls(text, "");
}

std::string in_one_line(std::string text) {
  for (char& c : text) {
    if (c == '\n' || c == '\r' || c == '\t') c = ' ';
  }
  return with_short_numbers(plain_line(text));
}

std::string plain_text(std::string_view text) {
  return without_controls(text, "\n\r\t");
}

std::string markdown_text(std::string_view text) {
  constexpr std::string_view kMarkup = "\\|`*[]#";
  std::string out;
  for (const char c : plain_line(text)) {
    if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '&') {
      out += "&amp;";
    } else {
      if (kMarkup.find(c) != std::string_view::npos) out += '\\';
      out += c;
    }
  }
  return out;
}

std::string shell_word(std::string_view text) {
  const bool is_plain = !text.empty() && std::all_of(text.begin(), text.end(), is_plain_in_shell);
  if (is_plain) return std::string(text);
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') {
      out += "'\\''";
    } else {
      out += c;
    }
  }
  return out + '\'';
}

bool is_harmless_command(std::string_view line) {
  bool is_quoted = false;
  for (size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    const auto code = static_cast<unsigned char>(c);
    if (code < ' ' || code == kDelete) return false;
    if (c == '\'') {
      is_quoted = !is_quoted;
    } else if (!is_quoted && c == '\\' && i + 1 < line.size() && line[i + 1] == '\'') {
      ++i;  // as shell_word writes a quote
    } else if (!is_quoted && c != ' ' && !is_plain_in_shell(c)) {
      return false;
    }
  }
  return !is_quoted;
}

}  // namespace sightline
