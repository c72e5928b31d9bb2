// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "pose/packed_points.h"
#include "pose/pose.h"
#include "pose/reprojection.h"
#include "pose/solver.h"

namespace sightline {

/// The pose that makes the sum of squared reprojection errors least, or why there is none.
struct LeastSquares {
  PoseStatus status = PoseStatus::kDiverged;
  Pose cam_from_centred;
  Matrix6d unit_covariance = Matrix6d::Zero();  ///< of cam_from_centred
  double cost_px2 = 0;                          ///< sum of squared residuals
  int iterations = 0;                           ///< of all starts
};

/// Least squares by Marquardt's method (pose/kernels/reprojection_kernel.h) from every start; of
/// the poses found the one of the lowest cost is returned. `weights` multiply the squared
/// residuals; none means ones. A point of weight zero does not take part, may lie behind the
/// camera, and is not looked at. kDegenerate without a start or where the points do not determine
/// the pose, kBehindCamera where every start has a point behind the camera, kDiverged at the
/// iteration limit.
LeastSquares least_squares(const Correspondences& c, std::span<const Pose> cam_from_centred_starts,
                           const LspeOptions& options, std::span<const double> weights = {});

/// The same on points that were packed with weights of any kind. unit_covariance is then the
/// inverse of the weighted Hessian.
LeastSquares least_squares(const PackedPoints& points,
                           std::span<const Pose> cam_from_centred_starts,
                           const LspeOptions& options);

}  // namespace sightline
