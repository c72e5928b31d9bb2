// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace sightline {

/// A solver's name for readers, as words: "orpe_tree" becomes "ORPE tree".
std::string solver_label(std::string_view name);

/// A status as words: "too_few_points" becomes "too few points".
std::string words(std::string_view status);

/// A text with blanks for its line ends: what users and libraries put into the text of an error may
/// hold some, and an error is one line.
std::string in_one_line(std::string text);

}  // namespace sightline
