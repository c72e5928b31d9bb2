// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "eval/compare/compare.h"
#include "eval/compare/pairing.h"

namespace sightline {

/// How the numbers of one cell differ, each with the p-value and verdict that it has by itself.
/// `base` and `now` are its entries in the two summary.json, `pairs` its trials, null where they
/// are not paired, `stream` the name of the random numbers of its bootstrap.
std::vector<Difference> compare_cell(const Json& base, const Json& now, const PairedCell* pairs,
                                     double tolerance, const std::string& stream);

/// Adjusts the p-values by Holm over all cells, withdraws the verdicts that do not stand after it,
/// and gives each cell its own.
void judge(std::vector<CellDifference>& cells);

}  // namespace sightline
