// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "pose/solver.h"

namespace sightline {

/// The Cramér-Rao bound of a pose: no unbiased estimator has a smaller covariance.
struct PoseBound {
  Matrix6d covariance;      ///< of (w, dt) in cam_from_target = (Exp(w) R, t + dt); rad, m
  double geodesic_rms_rad;  ///< sqrt of the trace of the rotation block
  double attitude_rms_rad;  ///< the bound of theta_error as the ORPE paper defines it
  double translation_rms;   ///< the bound of T_error, a fraction of the imaging distance
};

/// The bound for independent Gaussian pixel noise of sd `sigma_px` on both coordinates of each
/// point: sigma^2 (J^T J)^-1, J the Jacobian of the pixels. It is proportional to sigma_px.
/// None when the points do not determine a pose or one is not in front of the camera.
std::optional<PoseBound> cramer_rao_bound(const Camera& camera,
                                          std::span<const Eigen::Vector3d> points_in_target,
                                          const Pose& cam_from_target, double sigma_px);

}  // namespace sightline
