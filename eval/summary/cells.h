// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "eval/statistics/error_statistics.h"
#include "eval/statistics/statistics.h"
#include "eval/summary/quantities.h"

namespace sightline {

struct Summary;

/// How the covariances that a solver reports fit its errors (NEES), over the trials that have one.
struct NeesSummary {
  int64_t trials = 0;
  /// 6 of true covariances, more where they are too small. It has no interval: where a covariance
  /// is far too small now and then, a sample's mean does not tell of what it did not meet.
  double mean = kNoNumber;
  /// 5.35 of true covariances, with an interval of order statistics.
  Measured median;
  /// Trials whose error lies in the reported 95 % region (NEES below the 95 % quantile of
  /// chi-squared with 6 degrees of freedom).
  double coverage95 = kNoNumber;
  Interval95 coverage95_ci95 = kNoInterval;
};

/// One solver in one cell, over all its trials: a failed trial (or one without an estimate) counts
/// as an infinite error, removes nothing and keeps all its outliers. What does not apply is NaN
/// (null in summary.json), in a cell without trials everything but the counts.
struct CellSummary : CellErrors {
  int condition = 0;
  std::string solver;
  int trials = 0;
  /// Of an orientation study, whose errors are means over a trial's copies: the trials with a copy
  /// that failed.
  int failures = 0;
  /// RMS geodesic error, capped, over the oracle's, on the trials in which the oracle has a pose;
  /// NaN, as the next, where a numeric study applies no noise.
  double ratio_to_oracle = kNoNumber;
  /// The median over the same trials of the ratio of the two errors, with an interval of order
  /// statistics, which holds whatever their law: that of an RMS does not (RmsRatio).
  Measured ratio_to_oracle_median;
  /// The mean errors, capped, on those trials, and how many they are: those of the oracle itself
  /// are its errors where it exists, and others' stand beside them.
  int oracle_trials = 0;
  double theta_beside_oracle_deg = kNoNumber;
  double t_beside_oracle_percent = kNoNumber;
  /// RMS geodesic error, capped, over that of the bound, on the trials that have a bound.
  double ratio_to_bound = kNoNumber;
  Measured ratio_to_bound_median;      ///< as for the oracle
  double false_removals = kNoNumber;   ///< inliers removed, a trial
  double missed_outliers = kNoNumber;  ///< outliers kept, a trial
  /// Trials with a pose in which exactly the outliers were removed.
  double exact_set_rate = kNoNumber;
  // 95 % intervals of the rates (rate_interval).
  Interval95 failure_rate_ci95 = kNoInterval;
  Interval95 exact_set_rate_ci95 = kNoInterval;
  NeesSummary nees;       ///< no trials where the solver reports no covariance
  int failed_copies = 0;  ///< of all trials of an orientation study

  void set_errors(const CellErrors& errors) { CellErrors::operator=(errors); }
};

/// What a cell's images gave, whatever the solver; NaN where it has no trials.
struct CellObservations {
  int condition = 0;
  int trials = 0;
  /// Of them, those that are an earlier one of the cell again: the same poses, errors and pixels to
  /// the last bit. They tell nothing new, but make intervals narrow, as where a seed is ignored.
  int repeated = 0;
  double found = kNoNumber;     ///< features a trial
  double outliers = kNoNumber;  ///< a trial
  /// Error of the found inliers, RMS of one coordinate: sqrt(mean(error_px^2) / 2). NaN without
  /// any.
  double inlier_rms_px = kNoNumber;
  /// Cramér-Rao bound of the pose from the found inliers, each feature with the noise that it shows
  /// in this cell (its inlier_rms_px), or in a numeric study with the noise applied, and no bound
  /// without any; features that the target does not have are left out. Of
  /// every trial that has a bound, capped as errors are: the mean for theta and T, to stand beside
  /// mean errors, and the RMS for the geodesic angle. NaN where no trial has one.
  double bound_theta_deg = kNoNumber;
  double bound_t_percent = kNoNumber;
  double bound_geodesic_deg = kNoNumber;
};

// ---- Lookup. A shard may lack trials of some conditions, and their cells. ----

/// What the summary says of a cell; null where it says nothing.
const CellSummary* find_cell(const Summary& summary, int condition, std::string_view solver);
const CellObservations* find_observations(const Summary& summary, int condition);

/// The same cell; one that holds no numbers where the summary says nothing.
const CellSummary& cell_at(const Summary& summary, int condition, std::string_view solver);

/// The cells of a solver, by condition.
std::vector<const CellSummary*> cells_of(const Summary& summary, std::string_view solver);

// ---- Over conditions, each of those that have trials weighing the same ----

/// The trials of all conditions.
int64_t trials_of(const Summary& summary);

/// How many conditions have trials.
int conditions_with_trials(const Summary& summary);

/// The mean of values that stand by condition; NaN where no condition has trials.
double mean_over_conditions(const Summary& summary, std::span<const double> values);

/// The same mean of what the images gave, and of a solver's cells.
double mean_over_conditions(const Summary& summary, double CellObservations::*member);
double mean_over_conditions(const Summary& summary, std::string_view solver,
                            double CellSummary::*member);

/// The mean of a solver's mean errors, with its interval: the conditions' trials are independent,
/// so that the half-widths of their intervals add as squares.
Measured mean_over_conditions(const Summary& summary, std::string_view solver,
                              ErrorSummary CellErrors::*error);

/// The solver that a report is about: ORPE where it takes part, else the first that needs no truth;
/// empty where there is none.
std::string lead_solver(const Study& study);

// ---- What a paper prints of the cells ----

/// The figure that the paper prints for a solver in a condition, or null.
const PaperFigure* paper_figure(const Condition& condition, std::string_view solver);

/// True when the paper prints a figure for any cell of the study.
bool has_paper_figures(const Study& study);

}  // namespace sightline
