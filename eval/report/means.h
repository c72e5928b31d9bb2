// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "eval/study/study.h"
#include "eval/summary/summary.h"

namespace sightline {

/// The solver that a report is about: ORPE where it takes part, else the first that needs no truth;
/// empty where there is none.
std::string lead_solver(const Study& study);

/// NaN where there is nothing to take a mean of.
struct MeanInterval {
  double mean = ErrorSummary::kNone;
  std::array<double, 2> ci95{ErrorSummary::kNone, ErrorSummary::kNone};
};

/// One solver over all conditions of a study that have trials (a shard may lack some), each
/// condition weighing the same: what the paper's text calls its average.
struct SolverMeans {
  std::string solver;
  int trials = 0;
  int failures = 0;
  MeanInterval theta_error_deg;
  MeanInterval t_error_percent;
  std::optional<PaperFigure> paper;  ///< of the same conditions, where it prints one for each
};

/// The conditions' trials are independent, so that the half-widths of their intervals add as
/// squares.
SolverMeans means_over_conditions(const Study& study, const Summary& summary,
                                  std::string_view solver);

/// The figure that the paper prints for a solver in a condition, or null.
const PaperFigure* paper_figure(const Condition& condition, std::string_view solver);

/// True when the paper prints a figure for any cell of the study.
bool has_paper_figures(const Study& study);

/// The mean over the conditions that have trials of what their images gave; NaN where none has.
double mean_over_conditions(const Summary& summary, double CellObservations::*member);

/// The trials of all conditions.
int64_t trials_of(const Summary& summary);

/// How many conditions have trials.
int conditions_with_trials(const Summary& summary);

/// What the summary says of a cell; null where it says nothing.
const CellSummary* find_cell(const Summary& summary, int condition, std::string_view solver);
const CellObservations* find_observations(const Summary& summary, int condition);

}  // namespace sightline
