// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "eval/report/chart.h"

namespace sightline {

/// A part of a report's page, with an entry in its table of contents.
struct PageSection {
  std::string name;  ///< its anchor
  std::string title;
  std::string html;
  std::vector<Chart> charts;  ///< that stand above the text
};

struct Page {
  std::string title;
  std::string given_html;  ///< a line under it: what the page is about
  std::string warning;     ///< what a reader must know first; may be empty
  std::vector<PageSection> sections;
};

/// One self-contained HTML file that opens from disk without a network. Sections with neither text
/// nor charts are left out.
std::string render_page(const Page& page);

}  // namespace sightline
