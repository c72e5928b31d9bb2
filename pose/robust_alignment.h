// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Absolute orientation where some of the pairs, or most of them, are wrong.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "pose/alignment.h"

namespace sightline {

/// Matched points in two frames. No weights mean that all are 1. A pair of weight w has noise of
/// variance sigma^2 / w. A pair with a coordinate that is not finite, or with a weight that is not
/// a positive number, is left out and listed as ignored.
struct MatchedPoints {
  std::span<const Eigen::Vector3d> in_a;
  std::span<const Eigen::Vector3d> in_b;
  std::span<const double> weights{};
};

struct RobustAlignmentOptions {
  /// Standard deviation of the noise of each coordinate of x_b (of a pair of weight 1); 0 where it
  /// is not known, and then at most about 3 % of the extent of the cloud in b is found.
  double sigma_m = 0;
  bool estimates_scale = false;
  /// orpe and ransac_umeyama: how often anything is removed from pairs that have no outlier.
  double false_alarm_rate = 0.01;
};

/// An alignment with what its solver thinks of each pair.
struct RobustAlignment : Alignment {
  std::vector<double> inlier_probabilities;  ///< one a pair; 0 of ignored ones
  std::vector<int> removed;                  ///< pairs judged outliers, ascending
  std::vector<int> ignored;  ///< pairs that could not be used, ascending; not among `removed`
  /// Whether so many pairs agree so well that chance can hardly have made it.
  bool is_significant = false;
};

/// One way to absolute orientation with outliers.
struct RobustAlignmentMethod {
  std::string_view name;
  std::string_view summary;
  RobustAlignment (*align)(const MatchedPoints& points, const RobustAlignmentOptions& options);
};

/// The catalogue, in the order in which it is listed. What holds for every method: a pose with
/// status kOk is a rigid one, the same input gives the same bits, and the frames and the unit of
/// length do not matter. kTooFewPoints: fewer than three pairs that can be used, or lists of
/// different lengths. kDegenerate: no three pairs that agree and are not collinear. kBadWeights:
/// not one a pair. kNotFinite: an option is not finite or negative.
std::span<const RobustAlignmentMethod> robust_alignment_methods();

/// The method of that name, or null.
const RobustAlignmentMethod* find_robust_alignment_method(std::string_view name);

/// What whoever has outliers calls: the method `consensus` (pose/orientation/consensus.cpp).
/// Coordinates in float are taken to double.
RobustAlignment align_with_outliers(const MatchedPoints& points,
                                    const RobustAlignmentOptions& options = {});
RobustAlignment align_with_outliers(std::span<const Eigen::Vector3f> points_in_a,
                                    std::span<const Eigen::Vector3f> points_in_b,
                                    std::span<const double> weights = {},
                                    const RobustAlignmentOptions& options = {});

}  // namespace sightline
