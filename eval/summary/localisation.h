// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "eval/records/records.h"
#include "eval/statistics/clustered_ratio.h"
#include "eval/statistics/statistics.h"

namespace sightline {

inline constexpr double kNearPx = 3;  ///< from the truth: near enough for any pose

/// How well and how often features were found: of one feature or of all, in one cell.
struct Localisation {
  int64_t visible = 0;
  int64_t found = 0;
  Measured found_rate;    ///< of those that are to be seen
  Measured outlier_rate;  ///< of those found
  // Of those that are to be seen alone:
  Measured near_rate;          ///< found within kNearPx of the truth
  Measured seen_outlier_rate;  ///< outliers of those found
  /// Of those within kNearPx, the distance from the truth: its median and its root mean square.
  double near_median_px = kNoNumber;
  double near_rms_px = kNoNumber;
  Measured rms_px;     ///< of the inliers' error, one coordinate
  Measured bias_u_px;  ///< mean error of the inliers
  Measured bias_v_px;
  Measured rms_sigmas;  ///< of the inliers' error in its own sigmas, one coordinate: 1 is honest
  std::map<ObservationLabel, int64_t> labels;  ///< how many observations bear each label
  /// Of the outliers: the 10th, 50th and 90th percentile of their distance from the truth, and the
  /// mean of the unit vectors towards them (long where they all lie to one side).
  std::array<double, 3> outlier_px{};
  std::array<double, 2> outlier_side{};
};

/// Gathers the observations of a feature or of several, trial by trial: observations of one trial
/// are not independent, so that it must be told where a trial ends.
class LocalisationStatistics {
 public:
  void add(const ObservationRecord& observation);
  /// Of a trial without any such observation too: it counts among the trials.
  void end_trial();
  /// A whole trial: all its observations, and its end.
  void add(const TrialRecord& trial);

  Localisation summary() const;

 private:
  // Sums over the observations of one trial.
  struct TrialSums {
    double visible = 0, seen = 0, seen_outliers = 0, near = 0;
    double found = 0, outliers = 0, inliers = 0, with_sigma = 0;
    double squares_px2 = 0, du_px = 0, dv_px = 0, squares_sigmas = 0;
  };

  void add_outlier(const ObservationRecord& observation, const Eigen::Vector2d& error);
  void add_inlier(const ObservationRecord& observation, const Eigen::Vector2d& error);

  TrialSums trial_;  // the trial that has not ended
  ClusteredRatio found_, outliers_, near_, seen_outliers_, squares_px2_, bias_u_px_, bias_v_px_,
      squares_sigmas_;
  std::map<ObservationLabel, int64_t> labels_;
  int64_t visible_ = 0, found_count_ = 0, outlier_count_ = 0;
  double side_u_ = 0, side_v_ = 0;
  std::vector<double> outlier_px_, near_px_;  // of the first kMostKept
  static constexpr size_t kMostKept = 100'000;
};

}  // namespace sightline
