// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <string>
#include <vector>

#include "eval/study/study.h"
#include "eval/summary/summary.h"

namespace sightline {

/// What is shown of the cells of a numeric or orientation study: a table each, in the terminal and
/// in the report, with a row a condition and a column a solver.
struct SweepQuantity {
  std::string heading;  ///< "theta_error / °, mean of the trials"
  double (*value)(const CellSummary& cell);
  /// The 95 % interval of the value; null where it has none.
  const std::array<double, 2>& (*interval)(const CellSummary& cell) = nullptr;
  double CellObservations::*bound = nullptr;  ///< in one more column; null where it has none
  bool is_detail = false;                     ///< of the report alone
  bool is_better_high = false;
  int decimals = -1;  ///< -1: as the values ask for
};

/// The quantities of a study's kind, those that it did not measure left out; none of a study with
/// images.
std::vector<SweepQuantity> sweep_quantities(const Study& study, const Summary& summary);

/// A cell of a sweep; cells that a shard lacks hold no numbers.
CellSummary sweep_cell(const Summary& summary, int condition, const std::string& solver);

/// Decimals for all values of a quantity: such that those above 0.01 show two or three digits.
int sweep_decimals(const Summary& summary, const SweepQuantity& quantity);

/// How the paper's claim stands in these trials, a sentence each; empty where the study has nothing
/// to hold against it.
std::vector<std::string> claim_verdicts(const Study& study, const Summary& summary);

/// The tables for the terminal.
std::string sweep_blocks(const Study& study, const Summary& summary);

}  // namespace sightline
