// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/terminal.h"

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include <sys/ioctl.h>
#include <unistd.h>

#include "eval/output/base64.h"
#include "eval/output/text_table.h"

namespace sightline {
namespace {

constexpr size_t kLeastColumns = 40;
constexpr std::string_view kRule = "─";
constexpr const char* kBold = "\033[1m";
constexpr const char* kRed = "\033[31m";
constexpr const char* kGreen = "\033[32m";
constexpr const char* kYellow = "\033[33m";
constexpr const char* kPlain = "\033[0m";

size_t chosen_width = kTextTableWidth;

// Characters, of which UTF-8's continuation bytes are none.
size_t characters(std::string_view text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; });
}

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

// Where the last column of a line begins; 0 where it has one.
size_t last_column(std::string_view line) {
  size_t begin = 0;
  for (size_t i = 2; i < line.size(); ++i) {
    if (line[i] != ' ' && line[i - 1] == ' ' && line[i - 2] == ' ') begin = i;
  }
  return line.find_first_not_of(' ') == begin ? 0 : begin;
}

// The words in lines that begin with so many blanks, but for the first. A word that is longer than
// a line stays whole: it may be a path that is to be copied.
std::vector<std::string> broken_at_blanks(std::string line, size_t indent, size_t columns) {
  std::vector<std::string> lines;
  while (characters(line) > columns) {
    const size_t first = line.find_first_not_of(' ', indent);
    size_t end = std::string::npos;
    for (size_t i = line.find(' ', first); i != std::string::npos; i = line.find(' ', i + 1)) {
      if (end != std::string::npos && characters(line.substr(0, i)) > columns) break;
      end = i;
    }
    if (end == std::string::npos) break;
    lines.push_back(line.substr(0, line.find_last_not_of(' ', end) + 1));
    line = std::string(indent, ' ') + line.substr(end + 1);
  }
  lines.push_back(line);
  return lines;
}

// A line that is too long, on several. A last column that begins too far right to have room there
// goes below the others.
std::vector<std::string> wrapped_line(const std::string& line, size_t columns) {
  constexpr size_t kIndentBelow = 6;
  const bool is_to_stay = line.starts_with(kRule) || line.starts_with("|");
  if (columns == 0 || characters(line) <= columns || is_to_stay) return {line};
  const size_t column = last_column(line);
  const size_t before = characters(std::string_view(line).substr(0, column));
  if (3 * before <= 2 * columns) return broken_at_blanks(line, before, columns);
  const std::string first = line.substr(0, line.find_last_not_of(' ', column - 1) + 1);
  std::vector<std::string> lines = broken_at_blanks(first, kIndentBelow, columns);
  const std::string rest = std::string(kIndentBelow, ' ') + line.substr(column);
  for (std::string& below : broken_at_blanks(rest, kIndentBelow, columns)) {
    lines.push_back(std::move(below));
  }
  return lines;
}

bool has_word(std::string_view line, std::string_view word) {
  const size_t place = line.find(word);
  if (place == std::string_view::npos) return false;
  const bool begins = place == 0 || line[place - 1] == ' ';
  const size_t end = place + word.size();
  return begins && (end == line.size() || line[end] == ' ' || line[end] == ':');
}

// The colour of a line that is no table's head; none for most.
const char* colour_of(std::string_view line) {
  if (line.starts_with("failed:") || line.starts_with("no pose:") ||
      line.starts_with("no alignment:") || line.find(", must be ") != std::string_view::npos) {
    return kRed;
  }
  if (line.starts_with("warning:")) return kYellow;
  return "";
}

// A word of a row of a table that tells a verdict, in its colour.
std::string with_verdict(std::string line) {
  constexpr std::pair<std::string_view, const char*> kVerdicts[] = {
      {"worse", kRed}, {"missing", kRed}, {"better", kGreen}, {"!", kRed}};
  for (const auto& [word, colour] : kVerdicts) {
    if (!has_word(line, word)) continue;
    const size_t place = line.find(word);
    return line.substr(0, place) + colour + std::string(word) + kPlain +
           line.substr(place + word.size());
  }
  return line;
}

}  // namespace

TextLook look_of_standard_output() {
  if (isatty(STDOUT_FILENO) == 0) return {};
  TextLook look;
  look.has_colour = variable("NO_COLOR").empty() && variable("TERM") != "dumb";
  winsize size{};
  const size_t told = std::strtoul(variable("COLUMNS").c_str(), nullptr, 10);
  if (told > 0) {
    look.columns = told;
  } else if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0) {
    look.columns = size.ws_col;
  }
  if (look.columns > 0) look.columns = std::max(look.columns, kLeastColumns);
  return look;
}

bool shows_pictures() {
  if (isatty(STDOUT_FILENO) == 0 || !variable("TMUX").empty() || !variable("STY").empty()) {
    return false;
  }
  const std::string terminal = variable("TERM"), program = variable("TERM_PROGRAM");
  return terminal == "xterm-kitty" || terminal == "xterm-ghostty" || program == "WezTerm" ||
         program == "ghostty";
}

std::string terminal_picture(std::string_view png) {
  constexpr size_t kChunk = 4096;  // of letters, the most that the protocol takes at once
  const std::string letters = base64(png);
  std::string out;
  for (size_t begin = 0; begin < letters.size(); begin += kChunk) {
    const bool is_last = begin + kChunk >= letters.size();
    // a=T: show it; f=100: a PNG; q=2: answer nothing; m: whether there is more
    out += begin == 0 ? "\033_Ga=T,f=100,q=2," : "\033_G";
    out += is_last ? "m=0;" : "m=1;";
    out += letters.substr(begin, kChunk) + "\033\\";
  }
  return out + "\n";
}

size_t text_width() {
  return chosen_width;
}

void set_text_width(size_t columns) {
  chosen_width = std::clamp(columns, kLeastColumns, kTextTableWidth);
}

std::string in_look(std::string_view text, const TextLook& look) {
  const std::vector<std::string> lines = lines_of(text);
  std::string out;
  for (size_t i = 0; i < lines.size();) {
    size_t end = i;  // of the paragraph, and of its head, which a rule ends
    size_t head = i;
    for (; end < lines.size() && !lines[end].empty(); ++end) {
      if (lines[end].starts_with(kRule)) head = end;
    }
    const char* const colour = look.has_colour && i < end ? colour_of(lines[i]) : "";
    for (; i < end; ++i) {
      for (const std::string& line : wrapped_line(lines[i], look.columns)) {
        const std::string_view style = i < head && look.has_colour ? kBold : colour;
        const bool is_plain = style.empty();
        out += is_plain ? (look.has_colour ? with_verdict(line) : line)
                        : std::string(style) + line + kPlain;
        out += '\n';
      }
    }
    if (i < lines.size()) out += '\n';
    ++i;
  }
  if (!text.empty() && text.back() != '\n' && !out.empty()) out.pop_back();
  return out;
}

std::string shown(std::string_view text) {
  return in_look(text, look_of_standard_output());
}

}  // namespace sightline
