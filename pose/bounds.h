// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "pose/line_observation.h"
#include "pose/solver.h"

namespace sightline {

/// The Cramér-Rao bound of a pose: no unbiased estimator has a smaller covariance.
struct PoseBound {
  Matrix6d covariance;      ///< of (w, dt) in cam_from_target = (Exp(w) R, t + dt); rad, m
  double geodesic_rms_rad;  ///< sqrt of the trace of the rotation block
  double attitude_rms_rad;  ///< the bound of theta_error as the ORPE paper defines it
  double translation_rms;   ///< the bound of T_error, a fraction of the imaging distance
};

/// L with L L^T = covariance, by which draws of unit noise become draws of it. None unless the
/// matrix is positive definite; rotation and translation may have any units.
std::optional<Matrix6d> root_of(const Matrix6d& covariance);

/// What a covariance of the pose says of its errors.
PoseBound pose_bound(const Matrix6d& covariance, const Pose& cam_from_target);

/// The bound for independent Gaussian noise of covariance `covariances_px2[i]` on point i's pixel:
/// (sum J_i^T C_i^-1 J_i)^-1, J_i the Jacobian of the pixel, lens included. It is proportional to
/// the noise. None when the points do not determine a pose, one is not in front of the camera, the
/// lists differ in length, or a covariance is not positive definite.
std::optional<PoseBound> cramer_rao_bound(const Camera& camera,
                                          std::span<const Eigen::Vector3d> points_in_target,
                                          const Pose& cam_from_target,
                                          std::span<const Eigen::Matrix2d> covariances_px2);

/// The bound of points and lines together: lines add sum J^T J / variance over their edge points
/// (pose/edge_points.h), J taken at the pixels where they are said to have been seen. There may be
/// points or lines alone. None also where a line cannot be used or has no residual at the pose.
std::optional<PoseBound> cramer_rao_bound(const Camera& camera,
                                          std::span<const Eigen::Vector3d> points_in_target,
                                          const Pose& cam_from_target,
                                          std::span<const Eigen::Matrix2d> covariances_px2,
                                          std::span<const LineObservation> lines);

/// The same for noise of standard deviation `sigma_px` > 0 on both coordinates of every point.
std::optional<PoseBound> cramer_rao_bound(const Camera& camera,
                                          std::span<const Eigen::Vector3d> points_in_target,
                                          const Pose& cam_from_target, double sigma_px);

}  // namespace sightline
