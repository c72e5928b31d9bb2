// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace sightline {

/// A file that reports are made of.
struct PageText {
  std::string_view file;  ///< its name: "answer.mustache", "page.css"
  std::string_view text;  ///< all that it holds
};

/// Every file of assets/report/ (templates for mustache, style sheet, scripts), and "chart.js", the
/// text of Chart.js from the system's package. The build puts them into the program, so that a
/// report is one file and an installed program needs none of them.
std::span<const PageText> page_texts();

/// The text of the file of that name. Throws std::logic_error for a name that is none of them.
std::string page_text(std::string_view file);

}  // namespace sightline
