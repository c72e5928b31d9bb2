// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/output/text_table.h"

#include <algorithm>

#include <fmt/format.h>

#include "eval/output/plain_text.h"
#include "eval/output/terminal.h"

namespace sightline {
namespace {

constexpr std::string_view kBetweenGroups = "  ";

// Columns on the terminal: UTF-8's continuation bytes take none.
size_t width(std::string_view text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; });
}

std::string padding(const std::string& text, size_t columns) {
  return std::string(columns - std::min(columns, width(text)), ' ');
}

std::string left(const std::string& text, size_t columns) {
  return text + padding(text, columns);
}
std::string right(const std::string& text, size_t columns) {
  return padding(text, columns) + text;
}

std::string without_trailing_spaces(std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  return line;
}

size_t width(const TextColumn& column) {
  size_t widest = width(column.name);
  for (const std::string& cell : column.cells) widest = std::max(widest, width(cell));
  return widest;
}

size_t width(const TextGroup& group) {
  size_t sum = group.columns.size() - 1;
  for (const TextColumn& column : group.columns) sum += width(column);
  return std::max(sum, width(group.title));
}

// Names and texts may be somebody's, and a terminal obeys control characters.
void make_plain(TextGroup& group) {
  group.title = plain_line(group.title);
  for (TextColumn& column : group.columns) {
    column.name = plain_line(column.name);
    for (std::string& cell : column.cells) cell = plain_line(cell);
  }
}

// One line of a group: `text_of` says what stands in each column.
template <typename TextOf>
std::string group_line(const TextGroup& group, const TextOf& text_of) {
  std::string line;
  for (const TextColumn& column : group.columns) {
    if (!line.empty()) line += ' ';
    line += right(text_of(column), width(column));
  }
  return left(line, width(group));
}

// A block of the groups that fit, taken off the front of `groups`.
std::string block_of_first(const std::vector<std::string>& labels, std::vector<TextGroup>& groups) {
  size_t label_width = 0;
  for (const std::string& label : labels) label_width = std::max(label_width, width(label));

  std::string titles(label_width, ' ');
  std::string names = titles;
  std::vector<std::string> lines;
  for (const std::string& label : labels) lines.push_back(left(label, label_width));
  size_t total = label_width;
  size_t fitting = 0;
  for (const TextGroup& group : groups) {
    total += kBetweenGroups.size() + width(group);
    if (fitting > 0 && total > text_width()) break;
    ++fitting;
    titles.append(kBetweenGroups) += left(group.title, width(group));
    names.append(kBetweenGroups) += group_line(group, [](const TextColumn& c) { return c.name; });
    for (size_t row = 0; row < lines.size(); ++row) {
      lines[row].append(kBetweenGroups) +=
          group_line(group, [row](const TextColumn& c) { return c.cells[row]; });
    }
  }
  groups.erase(groups.begin(), groups.begin() + static_cast<std::ptrdiff_t>(fitting));

  std::string block;
  const std::string title_line = without_trailing_spaces(titles);
  if (!title_line.empty()) block += title_line + "\n";
  block += without_trailing_spaces(names) + "\n";
  for (size_t i = 0; i < width(names); ++i) block += "─";
  block += "\n";
  for (const std::string& line : lines) block += without_trailing_spaces(line) + "\n";
  return block;
}

}  // namespace

std::string shortened(const std::string& text, size_t columns) {
  if (width(text) <= columns) return text;
  std::string kept = text;
  while (width(kept) >= columns) kept.pop_back();
  return kept + "…";
}

std::string wrapped(std::string_view text) {
  std::string lines;
  std::string line;
  while (!text.empty()) {
    const size_t end = std::min(text.find(' '), text.size());
    const std::string word = shortened(std::string(text.substr(0, end)), text_width());
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!line.empty() && width(line) + 1 + width(word) > text_width()) {
      lines += line + "\n";
      line.clear();
    }
    line += line.empty() ? word : " " + word;
  }
  return lines + line + "\n";
}

std::string text_block(const std::string& heading, const std::vector<std::string>& labels,
                       std::vector<TextGroup> groups) {
  std::vector<std::string> plain_labels;
  for (const std::string& label : labels) plain_labels.push_back(plain_line(label));
  for (TextGroup& group : groups) make_plain(group);
  std::string text;
  while (!groups.empty()) {
    text += fmt::format("\n{}\n{}", heading, block_of_first(plain_labels, groups));
  }
  return text;
}

}  // namespace sightline
