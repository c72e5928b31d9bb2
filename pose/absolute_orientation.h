// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include <Eigen/Core>

#include "pose/pose.h"

namespace sightline {

enum class OrientationStatus {
  kOk,
  kTooFewPoints,  ///< fewer than three points, or lists of different lengths
  kDegenerate,    ///< collinear or coincident points: the rotation is not determined
  kNotFinite,     ///< a coordinate is NaN or infinite
};

struct OrientationEstimate {
  OrientationStatus status = OrientationStatus::kTooFewPoints;
  Pose b_from_a;  ///< meaningful only with status kOk
};

/// The rotation A that maximises tr(A^T B), B any 3x3 matrix, without a singular value
/// decomposition: the fast closed form of Li et al. 2012, equations (16) to (22) (Markley's FOAM),
/// lambda found by Newton's method.
/// Deviation: the closed form errs with the inverse square of the gap g = (s2 + sign(det B) s3)/s1
/// between B's singular values; where g is small one Newton step on SO(3) restores full precision,
/// and where it is smaller still, or det B < 0 with a small gap, the SVD takes over.
/// Status kDegenerate when g is below 1e-12 (the maximiser is not unique), kNotFinite, or kOk.
OrientationEstimate fast_rotation(const Eigen::Matrix3d& b);

/// The least-squares pose b_from_a of matched points, sum |x_b - (R x_a + t)|^2 -> min, by
/// fast_rotation. Needs three points that are not collinear. Points in metres, any offset: sums are
/// shifted by the centroid.
OrientationEstimate fast_absolute_orientation(std::span<const Eigen::Vector3d> points_in_a,
                                              std::span<const Eigen::Vector3d> points_in_b);

/// One way to the absolute orientation. In the catalogue for comparison; whoever wants a pose calls
/// fast_absolute_orientation.
struct OrientationMethod {
  std::string_view name;
  std::string_view summary;
  OrientationEstimate (*estimate)(std::span<const Eigen::Vector3d> points_in_a,
                                  std::span<const Eigen::Vector3d> points_in_b);
};

/// The catalogue, in the order in which it is listed.
std::span<const OrientationMethod> orientation_methods();

/// The method of that name, or null.
const OrientationMethod* find_orientation_method(std::string_view name);

}  // namespace sightline
