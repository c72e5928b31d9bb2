// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "eval/compare/compare.h"

namespace sightline {

/// What changed, as tables for the terminal.
std::string to_text(const Comparison& comparison);

/// All numbers of all cells, as Markdown.
std::string to_markdown(const Comparison& comparison);

/// All numbers of all cells, as JSON: an interval that is not known, and a number that is none, is
/// null.
std::string to_json(const Comparison& comparison);

/// The changes of a cell in one line; empty where nothing has changed.
std::string changes_text(const CellDifference& cell);

}  // namespace sightline
