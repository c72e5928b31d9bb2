// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/records/caps.h"
#include "eval/records/records.h"
#include "eval/statistics/statistics.h"
#include "eval/study/study.h"
#include "eval/summary/localisation.h"

namespace sightline {

/// How the covariances that a solver reports fit its errors (NEES), over the trials that have one.
struct NeesSummary {
  int64_t trials = 0;
  double mean = kNoNumber;  ///< 6 of true covariances, more where they are too small
  Interval95 mean_ci95 = kNoInterval;
  /// Trials whose error lies in the reported 95 % region (NEES below the 95 % quantile of
  /// chi-squared with 6 degrees of freedom).
  double coverage95 = kNoNumber;
  Interval95 coverage95_ci95 = kNoInterval;
};

/// One solver in one cell, over all its trials: a failed trial (or one without an estimate) counts
/// as an infinite error, removes nothing and keeps all its outliers. What does not apply is NaN
/// (null in summary.json), in a cell without trials everything but the counts.
struct CellSummary {
  int condition = 0;
  std::string solver;
  int trials = 0;
  int failures = 0;
  ErrorSummary theta_error_deg;
  ErrorSummary t_error_percent;
  ErrorSummary geodesic_deg;
  /// RMS geodesic error, capped, over the oracle's, on the trials in which the oracle has a pose;
  /// NaN, as the next, where a numeric study applies no noise.
  double ratio_to_oracle = ErrorSummary::kNone;
  /// RMS geodesic error, capped, over that of the bound, on the trials that have a bound.
  double ratio_to_bound = ErrorSummary::kNone;
  double false_removals = ErrorSummary::kNone;   ///< inliers removed, a trial
  double missed_outliers = ErrorSummary::kNone;  ///< outliers kept, a trial
  /// Trials with a pose in which exactly the outliers were removed.
  double exact_set_rate = ErrorSummary::kNone;
  // 95 % intervals: Wilson's of the rates, RmsRatio's of the ratios.
  Interval95 failure_rate_ci95 = kNoInterval;
  Interval95 exact_set_rate_ci95 = kNoInterval;
  Interval95 ratio_to_oracle_ci95 = kNoInterval;
  Interval95 ratio_to_bound_ci95 = kNoInterval;
  NeesSummary nees;  ///< no trials where the solver reports no covariance

  // Of an orientation study, whose trials are draws with noisy copies. A trial's errors are means
  // over its copies; the trials with a copy that failed are `failures`.
  int failed_copies = 0;
  ErrorSummary angle_error_deg;  ///< mean of the three attitude angles' absolute errors
  ErrorSummary time_ns;          ///< a solve; not in summary.json, as times do not repeat
};

/// What a cell's images gave, whatever the solver; NaN where it has no trials.
struct CellObservations {
  int condition = 0;
  int trials = 0;
  /// Of them, those that are an earlier one of the cell again: the same poses, errors and pixels to
  /// the last bit. They tell nothing new, but make intervals narrow, as where a seed is ignored.
  int repeated = 0;
  double found = ErrorSummary::kNone;     ///< features a trial
  double outliers = ErrorSummary::kNone;  ///< a trial
  /// Error of the found inliers, RMS of one coordinate: sqrt(mean(error_px^2) / 2). NaN without
  /// any.
  double inlier_rms_px = ErrorSummary::kNone;
  /// Cramér-Rao bound of the pose from the found inliers, each feature with the noise that it shows
  /// in this cell (its inlier_rms_px), or in a numeric study with the noise applied, and no bound
  /// without any; features that the target does not have are left out. Of
  /// every trial that has a bound, capped as errors are: the mean for theta and T, to stand beside
  /// mean errors, and the RMS for the geodesic angle. NaN where no trial has one.
  double bound_theta_deg = ErrorSummary::kNone;
  double bound_t_percent = ErrorSummary::kNone;
  double bound_geodesic_deg = ErrorSummary::kNone;
};

/// What became of one feature in one cell.
struct FeatureSummary {
  int condition = 0;
  std::string feature;
  int visible = 0;
  int found = 0;
  int outliers = 0;
  double inlier_rms_px = 0;  ///< as in CellObservations
  double median_px = 0;      ///< of the found ones' errors, outliers among them; NaN of none
};

struct Summary {
  std::vector<CellSummary> cells;  ///< by condition, then in the study's order of solvers
  std::vector<CellObservations> observations;      ///< by condition
  std::vector<FeatureSummary> features;            ///< by condition, then in the study's order
  std::optional<ExtractionStatistics> extraction;  ///< of a study with images
};

/// Trials that are all in memory, in any order, as a source; they must outlive it.
TrialSource in_order(std::span<const TrialRecord> trials);

/// Goes through the trials once, or where there are images twice, in memory that does not grow with
/// their number once each cell has ErrorStatistics::kMostValuesKept. Of an orientation study there
/// are cells, and observations that hold nothing but the number of trials.
Summary summarise(const Study& study, const TrialSource& trials);

/// The same of trials in memory, whose order does not matter.
Summary summarise(const Study& study, std::span<const TrialRecord> trials);

/// How many trials a relative half-width of `target` of the 95 % intervals of a cell's mean
/// theta_error and T_error needs (trials_for); none of a cell whose trials say nothing, or err by
/// rounding alone.
std::optional<int64_t> trials_needed(const CellSummary& cell, double target);

}  // namespace sightline
