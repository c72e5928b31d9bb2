// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The functions of the catalogue of absolute orientation (pose/absolute_orientation.cpp), one a
// file of this folder (that of fast.cpp is public). Reach them through find_orientation_method. All
// take moments of status kOk.
#pragma once

#include "pose/absolute_orientation.h"
#include "pose/pair_moments.h"

namespace sightline {

OrientationEstimate orient_by_arun(const PairMoments& moments);
OrientationEstimate orient_by_direct_linear(const PairMoments& moments);
OrientationEstimate orient_by_gauss_newton(const PairMoments& moments);
OrientationEstimate orient_by_horn_orthonormal(const PairMoments& moments);
OrientationEstimate orient_by_horn_quaternion(const PairMoments& moments);
OrientationEstimate orient_by_umeyama(const PairMoments& moments);
OrientationEstimate orient_by_umeyama_scaled(const PairMoments& moments);
OrientationEstimate orient_by_walker_dual_quaternion(const PairMoments& moments);

// What they share.

/// The estimate whose translation takes mean to mean: t = mean_b - scale R mean_a, equation (7).
inline OrientationEstimate estimate_about_means(const PairMoments& moments,
                                                const Eigen::Matrix3d& rotation, double scale = 1) {
  OrientationEstimate estimate{OrientationStatus::kOk, {}, scale};
  estimate.b_from_a.rotation = rotation;
  estimate.b_from_a.translation = moments.mean_in_b() - scale * (rotation * moments.mean_in_a());
  // Clouds of such different sizes that their ratio leaves the range of double.
  const bool is_finite = estimate.b_from_a.translation.allFinite() && scale * 0 == 0;
  return is_finite ? estimate : OrientationEstimate{OrientationStatus::kDegenerate, {}};
}

/// The rotation that maximises tr(A^T B) by a singular value decomposition, and the maximum.
struct SvdRotation {
  OrientationStatus status = OrientationStatus::kDegenerate;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  double trace = 0;  ///< s1 + s2 + sign(det B) s3
};

/// Umeyama (1991), equations (40) to (43). kDegenerate where s2 + sign(det B) s3 is below
/// max(1e-12 s1, smallest_gap).
SvdRotation rotation_by_svd(const Eigen::Matrix3d& b, double smallest_gap);

}  // namespace sightline
