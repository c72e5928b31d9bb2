// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "pose/least_squares.h"
#include "pose/pose.h"
#include "pose/reprojection.h"
#include "pose/solver.h"

namespace sightline {

/// The points that a pose is fitted to: all points of a prepared problem or some of them, with the
/// residual of each multiplied by a 2x2 matrix where the pixels are known unequally well. It owns
/// nothing: what it refers to must outlive it.
struct FitPoints {
  const Correspondences& correspondences;
  std::span<const int> kept;                   ///< indices of the points; empty: all
  std::span<const Eigen::Matrix2d> whitening;  ///< one a point of the problem; empty: identities

  std::size_t size() const { return kept.empty() ? correspondences.size() : kept.size(); }
  std::size_t index(std::size_t i) const {
    return kept.empty() ? i : static_cast<std::size_t>(kept[i]);
  }
};

/// The reprojection error of the i-th fitted point (`reproject`, pose/reprojection.h), whitened.
/// None for a point at or behind the camera's plane.
std::optional<Reprojection> reproject(const FitPoints& points, std::size_t i,
                                      const Pose& cam_from_centred);

/// The pose of least squares of these points (`least_squares`, pose/least_squares.h).
LeastSquares least_squares(const FitPoints& points, std::span<const Pose> cam_from_centred_starts,
                           const LspeOptions& options);

/// The covariance of cam_from_centred at unit noise: (J^T J)^-1, J the whitened Jacobian of these
/// points. None where the points do not determine the pose.
std::optional<Matrix6d> unit_covariance(const FitPoints& points, const Pose& cam_from_centred);

/// The estimate given, with this pose and its unit covariance filled in. Where the points do not
/// determine the pose the status becomes kDegenerate and neither is filled in.
PoseEstimate with_pose(PoseEstimate estimate, const FitPoints& points,
                       const Pose& cam_from_centred);

/// The same for a pose that is the minimax of these points: its covariance is the minimax's own
/// (minimax_variance_factor, pose/minimax_null.h).
PoseEstimate with_minimax_pose(PoseEstimate estimate, const FitPoints& points,
                               const Pose& cam_from_centred);

/// The estimate given, with the pose that least squares on these points finds from a start near it
/// filled in, and with its unit covariance. Where least squares fails its status is the estimate's.
PoseEstimate with_least_squares(PoseEstimate estimate, const FitPoints& points,
                                const Pose& cam_from_centred_start, const LspeOptions& options);

}  // namespace sightline
