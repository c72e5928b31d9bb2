// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Graduated non-convexity with the Geman-McClure loss, r_i the reprojection error of point i:
//
//   min sum_i rho_mu(|r_i|),   rho_mu(r) = mu c^2 r^2 / (mu c^2 + r^2),   mu falling to 1,
//   by weighted least squares, w_i = (mu c^2 / (mu c^2 + r_i^2))^2.
//
// Yang, Antonante, Tzoumas, Carlone, "Graduated non-convexity for robust spatial perception", IEEE
// Robotics and Automation Letters 5(2), 2020: equation (8) for rho_mu, (13) for the weights, remark
// 5 for mu: it begins at 2 max r^2 / c^2 of least squares on all points, where the cost is convex
// over the residuals, and is divided by 1.4 a stage.
//
// Needs four points that are not collinear, or three with an initial pose. Every point must end in
// front of the camera. Uses covariances_px2 (they whiten the residuals), else sigma_px, else the
// sigma of Huber's fit (pose/robust.h), and of OutlierOptions false_alarm_rate: c, the largest
// residual that noise is believed to have, is the root of squared_threshold times sigma. `removed`
// are the points whose final weight is below 1/4, that of r = c; they are weighed, not left out,
// and max_removed does not bind.
//
// Deviations: a stage is a few Marquardt steps from the pose of the last, not a global weighted
// solver, which reprojection errors do not have; the last stage, mu = 1, is run until it converges.

#include <algorithm>

#include "pose/robust.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {
namespace {

constexpr double kMuFactor = 1.4;
constexpr double kLargestMu = 1e20;
constexpr int kStageIterations = 2;
constexpr double kStageTolerance = 1e-3;
constexpr double kWeightAtBound = 0.25;

struct GemanMcClureLoss {
  double mu_c2;

  Loss operator()(double r2) const {
    const double ratio = mu_c2 / (mu_c2 + r2);
    return {0.5 * r2 * ratio, ratio * ratio, ratio * ratio * (4 * ratio - 3)};
  }
};

RobustFit fit_gnc(const WhitenedCorrespondences& c, const Pose& start, double unit_bound2,
                  const LspeOptions& options) {
  const std::optional<RobustFit> huber =
      c.sigma > 0 ? std::nullopt : std::optional(fit_huber(c, start, options));
  const double sigma = huber ? huber->sigma : c.sigma;
  const double c2 = unit_bound2 * sigma * sigma;
  const LeastSquares all = whitened_least_squares(c, std::span(&start, 1), options);
  if (all.status == PoseStatus::kBehindCamera) {
    RobustFit failed;
    failed.status = all.status;
    return failed;
  }
  Pose pose = all.cam_from_centred;
  int iterations = all.iterations + (huber ? huber->iterations : 0);
  const double largest = std::ranges::max(squared_residuals(c, pose));
  for (double mu = std::min(2 * largest / c2, kLargestMu); mu > 1; mu /= kMuFactor) {
    const RobustFit stage =
        minimise_loss(c, pose, GemanMcClureLoss{mu * c2}, kStageIterations, kStageTolerance);
    pose = stage.cam_from_centred;
    iterations += stage.iterations;
  }
  RobustFit fit = minimise_loss(c, pose, GemanMcClureLoss{c2},
                                kLimitFactor * options.max_iterations, options.step_tolerance);
  fit.sigma = sigma;
  fit.iterations += iterations;
  return fit;
}

}  // namespace

PoseEstimate solve_gnc(const PoseProblem& problem, const SolverOptions& options) {
  const PreparedWhitened prepared = prepare_whitened(problem);
  if (prepared.status != PoseStatus::kOk) return estimate_of_failure(prepared.status);
  const WhitenedCorrespondences& c = prepared.correspondences;
  const double unit_bound2 = squared_threshold(options.outliers.false_alarm_rate, c.size());
  const RobustFit fit =
      best_fit(starting_poses(c.points, problem.initial_cam_from_target),
               [&](const Pose& start) { return fit_gnc(c, start, unit_bound2, options.lspe); });
  return estimate_from_fit(fit, c, kWeightAtBound);
}

}  // namespace sightline
