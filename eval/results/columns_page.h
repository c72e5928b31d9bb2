// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace sightline {

/// The columns of results.csv, timings.csv and of the tables of results.sqlite, with unit and
/// meaning, as Markdown: what `sightline list columns` prints and docs/columns.md holds.
std::string columns_page();

}  // namespace sightline
