// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <span>

#include <Eigen/Core>

#include "pose/absolute_orientation.h"

namespace sightline {

/// What every method of absolute orientation needs of matched points x_a, x_b with weights w.
struct PairMoments {
  OrientationStatus status = OrientationStatus::kTooFewPoints;  ///< what follows holds for kOk only
  Eigen::Index positive_weights = 0;                            ///< points that count
  double weight = 0;                                            ///< sum w
  /// A point of each cloud, and the weighted mean seen from there: exact where the mean itself
  /// would round, far from the frame's origin.
  Eigen::Vector3d origin_in_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d origin_in_b = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_from_origin_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_from_origin_b = Eigen::Vector3d::Zero();
  /// sum w (x_b - mean_b)(x_a - mean_a)^T: B of the paper's equation (8).
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  /// sum w (x_a - mean_a)(x_a - mean_a)^T, if asked for.
  Eigen::Matrix3d spread_a = Eigen::Matrix3d::Zero();
  /// What the rounding of the coordinates alone may give a singular value of `cross`.
  double rounding = 0;
  /// The unit in which cross (squared), spread_a (squared), and rounding (squared) are: 1 but for
  /// coordinates whose products would leave the range of double.
  double unit_m = 1;

  Eigen::Vector3d mean_in_a() const { return origin_in_a + mean_from_origin_a; }
  Eigen::Vector3d mean_in_b() const { return origin_in_b + mean_from_origin_b; }
};

/// Below this part of the largest singular value, s2 + sign(det B) s3 is rounding of the sums: the
/// points are collinear, or mirrored with two axes alike, and the rotation is not determined.
inline constexpr double kDegenerateGap = 1e-12;

/// The smallest s2 + sign(det B) s3 that determines a rotation, B = moments.cross.
inline double smallest_gap(const PairMoments& moments, double largest_singular_value) {
  return std::max(kDegenerateGap * largest_singular_value, moments.rounding);
}

/// The moments in one pass over the points (double arithmetic whatever the points are in), shifted
/// by the first point that counts; in a second pass, shifted by the means, where that point lies so
/// far out that the sums would cancel. Weights: empty (all 1), or one a point, finite, >= 0.
template <typename Scalar>
PairMoments pair_moments(std::span<const Eigen::Matrix<Scalar, 3, 1>> points_in_a,
                         std::span<const Eigen::Matrix<Scalar, 3, 1>> points_in_b,
                         std::span<const double> weights, bool with_spread);

extern template PairMoments pair_moments<double>(std::span<const Eigen::Vector3d>,
                                                 std::span<const Eigen::Vector3d>,
                                                 std::span<const double>, bool);
extern template PairMoments pair_moments<float>(std::span<const Eigen::Vector3f>,
                                                std::span<const Eigen::Vector3f>,
                                                std::span<const double>, bool);

}  // namespace sightline
