// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "eval/records.h"
#include "eval/statistics.h"
#include "eval/study.h"

namespace sightline {

/// Errors are capped here before means and RMS are taken.
constexpr double kAngleCapDeg = 20;
constexpr double kTranslationCapPercent = 20;

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
  std::vector<CellObservations> observations;  ///< by condition
  std::vector<FeatureSummary> features;        ///< by condition, then in the study's order
};

/// The order of the trials does not matter. Of an orientation study there are cells, and
/// observations that hold nothing but the number of trials.
Summary summarise(const Study& study, std::span<const TrialRecord> trials);

/// summary.json: the contract that other programs read; stable order; numbers read back as
/// they were, null for NaN and infinity. "capped" counts the trials whose geodesic
/// error is at the cap, failures among them. In an orientation study cells have a method's name as
/// "solver", and besides "copies" (a trial), "failed_copies" (in all) and "angle_error_deg".
std::string to_json(const Study& study, const Summary& summary);

/// results.csv: one row a trial and solver, by trial and then in the study's order; no wall times.
/// RFC 4180 but for its line ends, which are "\n". A failed trial's numbers are empty fields, but
/// for the removals, which count as in CellSummary. Quaternions are scalar first.
std::string to_csv(const Study& study, std::span<const TrialRecord> trials);

/// timings.csv of a study that takes times: one row a trial and method, as in results.csv, with the
/// mean wall time of a solve; empty of any other study.
std::string to_timings_csv(const Study& study, std::span<const TrialRecord> trials);

}  // namespace sightline
