// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Huber's M-estimator of the pose, r_i the reprojection error of point i:
//
//   min sum_i rho(|r_i|),   rho(r) = r^2 / 2 for r <= k sigma, k sigma (r - k sigma / 2) beyond.
//
// Huber, "Robust estimation of a location parameter", Annals of Mathematical Statistics 35(1),
// 1964; k is kHuberWidth, 95 % efficient for Gaussian vectors of the plane.
//
// Needs four points that are not collinear, or three with an initial pose. Every point must end in
// front of the camera. Uses covariances_px2 (they whiten the residuals), else sigma_px, else the
// median residual (fit_huber, pose/robust.h), and of OutlierOptions false_alarm_rate: `removed` are
// the points whose weight k sigma / r is below that of a residual at squared_threshold; they are
// weighed, not left out, and max_removed does not bind. (The rate holds for a known sigma; with the
// estimated one, of eight good points one is reported in about 8 % at a rate of 1 %.)
//
// The weight falls only as 1 / r: an outlier goes on pulling, with the force of a k sigma residual.

#include "pose/robust.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {

PoseEstimate solve_huber(const PoseProblem& problem, const SolverOptions& options) {
  const PreparedWhitened prepared = prepare_whitened(problem);
  if (prepared.status != PoseStatus::kOk) return estimate_of_failure(prepared.status);
  const WhitenedCorrespondences& c = prepared.correspondences;
  const RobustFit fit =
      best_fit(starting_poses(c.points, problem.initial_cam_from_target),
               [&](const Pose& start) { return fit_huber(c, start, options.lspe); });
  const double t2 = squared_threshold(options.outliers.false_alarm_rate, c.size());
  return estimate_from_fit(fit, c, HuberLoss{kHuberWidth}(t2).weight);
}

}  // namespace sightline
