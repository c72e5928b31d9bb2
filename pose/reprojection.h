// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What all solvers share: a problem made ready for computing, and the reprojection error of a point
// with its analytic derivative.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "pose/pose.h"
#include "pose/solver.h"

namespace sightline {

/// A problem as the solvers see it. Points are taken about their centroid, so that the target's
/// frame does not matter and rotation and translation are nearly uncorrelated; this frame is called
/// `centred`. Pixels are free of distortion and relative to the principal point, so that the point
/// (x, y, z) of the camera frame is seen at (fx x / z, fy y / z).
struct Correspondences {
  double fx_px = 1;
  double fy_px = 1;
  Eigen::Vector3d centroid_in_target = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> points_in_centred;
  std::vector<Eigen::Vector2d> pixels;

  std::size_t size() const { return points_in_centred.size(); }
};

/// A problem that has been checked.
struct PreparedProblem {
  PoseStatus status = PoseStatus::kDegenerate;  ///< kOk: the correspondences may be used
  Correspondences correspondences;
};

/// Checks a problem and undoes the lens. kTooFewPoints below kMinimumPosePoints (with an initial
/// pose kMinimumPosePointsFromInitial) or when the lists differ in length; kDegenerate when a
/// number is not finite, a pixel cannot be undistorted, the camera has no positive focal length,
/// the initial pose is not a rigid one, or the points are collinear or coincide.
PreparedProblem prepare(const PoseProblem& problem);

/// The same correspondences (in the same centred frame) but for one.
Correspondences without(const Correspondences& all, std::size_t index);

/// cam_from_centred = cam_from_target * target_from_centred, and back.
Pose to_centred(const Pose& cam_from_target, const Correspondences& c);
Pose from_centred(const Pose& cam_from_centred, const Correspondences& c);

/// The covariance of (w, dt) of cam_from_target, given that of cam_from_centred.
Matrix6d covariance_from_centred(const Matrix6d& covariance, const Pose& cam_from_centred,
                                 const Correspondences& c);

/// The reprojection error of one point, predicted - observed in pixels, and its derivative by (w,
/// dt) in cam_from_centred = (Exp(w) R, t + dt).
struct Reprojection {
  Eigen::Vector2d residual_px;
  Eigen::Matrix<double, 2, 6> jacobian;
};

/// The error of the point at `index`, alone or with its derivative. None for a point at or behind
/// the camera's plane.
std::optional<Eigen::Vector2d> residual_px(const Correspondences& c, std::size_t index,
                                           const Pose& cam_from_centred);
std::optional<Reprojection> reproject(const Correspondences& c, std::size_t index,
                                      const Pose& cam_from_centred);

/// The inverse of an information matrix, which is a covariance. None where the matrix is singular
/// to rounding (kernel::kLargestInflation), whatever the units of its rows.
std::optional<Matrix6d> inverse_information(const Matrix6d& information);

}  // namespace sightline
