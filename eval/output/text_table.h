// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// Tables of text for the terminal: UTF-8, no line wider than this, none ending in a space.
constexpr size_t kTextTableWidth = 100;

/// A column of a block: its cells, one a row, are set flush right.
struct TextColumn {
  std::string name;
  std::vector<std::string> cells;
};

/// Columns under one title that belong together and are never torn apart.
struct TextGroup {
  std::string title;
  std::vector<TextColumn> columns;
};

/// A heading and under it rows with a label each and the groups' columns. Groups that do not fit
/// beside each other stand in further blocks, with heading and labels again.
std::string text_block(const std::string& heading, const std::vector<std::string>& labels,
                       std::vector<TextGroup> groups);

/// The text, with an ellipsis for what goes beyond so many characters.
std::string shortened(const std::string& text, size_t columns);

/// The text in lines that break at spaces; a word longer than a line is shortened.
std::string wrapped(std::string_view text);

}  // namespace sightline
