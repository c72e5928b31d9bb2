// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Texts that we did not write (names of files, of targets, what a received folder holds) on their
// way into something that gives some characters a meaning: one escaper for each such language.
// HTML's is in html.h, JUnit's in junit.h, CSV's in csv.h, TOML's in scenes/files/toml_text.h.
#pragma once

#include <string>
#include <string_view>

namespace sightline {

/// The text as one line of valid UTF-8 that steers nothing: instead of a control character stands
/// its picture (U+2400 and on), instead of a byte that is no UTF-8, or of a control character
/// beyond ASCII, U+FFFD. For terminals, gnuplot, XML and whoever else takes lines.
std::string plain_line(std::string_view text);

/// The same with blanks for line ends and tabs: what users and libraries put into the text of an
/// error may hold some, and an error is one line; of a number of over 40 digits the first 12.
std::string in_one_line(std::string text);

/// The same as plain_line, but line ends and tabs stay: for texts of several lines.
std::string plain_text(std::string_view text);

/// The text as it may stand in a line or a table's cell of Markdown: plain_line, with what would be
/// markup, HTML or the end of the cell escaped. (An underscore within a word is none of these.)
std::string markdown_text(std::string_view text);

/// The text as one word of a POSIX shell; as it stands where that means nothing else.
std::string shell_word(std::string_view text);

/// Whether a line, copied into a shell, does nothing but run a program with words: no operators, no
/// substitutions, no control characters.
bool is_harmless_command(std::string_view line);

}  // namespace sightline
