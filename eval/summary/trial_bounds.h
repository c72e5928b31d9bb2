// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "eval/records/records.h"
#include "eval/study/study.h"

namespace sightline {

/// The Cramér-Rao bound of one trial's pose, in the units of errors and capped like them.
struct TrialBound {
  Eigen::Matrix<double, 6, 6> covariance;  ///< of (w, dt); radians and metres
  double theta_deg = 0;
  double t_percent = 0;
  double geodesic_deg = 0;
};

/// The bounds of a study's trials: of the pose from the found inliers, whose noise is that which a
/// numeric study applies, or which the features of an image study show.
class TrialBounds {
 public:
  /// The study must outlive it.
  explicit TrialBounds(const Study& study);

  /// What the features of a condition of an image study show, by name: once for each condition,
  /// before its trials.
  void set_noise_px(int condition, std::map<std::string, double> noise_px);

  /// True of a numeric study's condition without noise: it has no bound, and exact solvers err by
  /// rounding alone, of which ratios of errors say nothing.
  bool is_noiseless(int condition) const;

  /// None for a trial whose inliers do not determine a pose, and of a condition without noise. A
  /// feature that the target does not have (any more: stored trials outlive the target's file)
  /// tells nothing.
  std::optional<TrialBound> of(const TrialRecord& trial) const;

 private:
  double noise_px(int condition, const std::string& feature) const;
  Eigen::Matrix2d covariance_px2(const TrialRecord& trial, const std::string& feature) const;

  const Study& study_;
  std::map<std::string, Eigen::Vector3d> positions_m_;   // of the target's features
  std::vector<std::map<std::string, double>> noise_px_;  // by condition, of an image study
};

}  // namespace sightline
