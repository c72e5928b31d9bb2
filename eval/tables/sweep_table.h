// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "eval/study/study.h"
#include "eval/summary/summary.h"

namespace sightline {

/// What is shown of the cells of a study: a chart each and, but for a study of images, a table
/// each, in the terminal and in the report, with a row a condition and a column a solver.
struct SweepQuantity {
  std::string heading;  ///< "theta_error / °, mean of the trials"
  std::function<double(const CellSummary&)> value;
  /// The 95 % interval of the value; null where it has none.
  std::function<Interval95(const CellSummary&)> interval = nullptr;
  double CellObservations::*bound = nullptr;  ///< in one more column; null where it has none
  double PaperFigure::*paper = nullptr;       ///< what the paper prints of it, in charts
  bool is_detail = false;                     ///< of the report alone
  bool is_better_high = false;
  int decimals = -1;  ///< -1: as the values ask for
};

/// The quantities of a study's kind, those that it did not measure left out.
std::vector<SweepQuantity> sweep_quantities(const Study& study, const Summary& summary);

/// Decimals for all values of a quantity: such that those above 0.01 show two or three digits.
int sweep_decimals(const Summary& summary, const SweepQuantity& quantity);

/// The tables for the terminal.
std::string sweep_blocks(const Study& study, const Summary& summary);

}  // namespace sightline
