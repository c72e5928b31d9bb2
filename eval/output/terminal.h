// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a terminal shows differently from a file or a pipe: no line wider than it is, and colours.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace sightline {

/// How a text is shown.
struct TextLook {
  size_t columns = 0;  ///< longer lines are wrapped; 0: none is
  bool has_colour = false;
};

/// Of standard output: its terminal's columns (of COLUMNS, where that is set, at least 40), and
/// colours unless NO_COLOR says otherwise (no-color.org) or the terminal is a dumb one; neither
/// where it is no terminal.
TextLook look_of_standard_output();

/// Whether standard output is a terminal that says that it shows pictures by kitty's graphics
/// protocol (kitty, Ghostty, WezTerm), with nothing between that would swallow them (tmux, screen).
bool shows_pictures();

/// A PNG as such a terminal takes it (https://sw.kovidgoyal.net/kitty/graphics-protocol/).
std::string terminal_picture(std::string_view png);

/// The width of tables of text: kTextTableWidth, or what the program has set once, at its start,
/// for the terminal that it runs in.
size_t text_width();
void set_text_width(size_t columns);

/// The text in this look. A line that is too long goes on below the beginning of its last column
/// (which two blanks part from what stands before it). The heads of tables are bold; red are
/// failures and what is worse or missing, green is what is better, yellow are warnings.
std::string in_look(std::string_view text, const TextLook& look);

/// The same in the look of standard output.
std::string shown(std::string_view text);

}  // namespace sightline
