// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Tukey's biweight M-estimator of the pose, begun from Huber's (pose/solvers/huber.cpp):
//
//   min sum_i rho(|r_i|),   rho(r) = (c^2 / 6) (1 - (1 - r^2 / c^2)^3) for r <= c, c^2 / 6 beyond.
//
// Beaton and Tukey, "The fitting of power series", Technometrics 16(2), 1974. c = kTukeyWidth
// sigma, 95 % efficient for Gaussian vectors of the plane. Beyond c a point has no weight at all,
// which Huber's cannot do; but rho is not convex, and the start decides.
//
// Preconditions, covariances, sigma and OutlierOptions as in huber.cpp: `removed` are the points
// whose weight (1 - r^2 / c^2)^2 is below that of a residual at squared_threshold (or zero).
// Where the biweight leaves the pose undetermined or does not converge, Huber's is the answer.

#include "pose/robust.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {
namespace {

constexpr double kTukeyWidth = 5.123;

struct TukeyLoss {
  double width;

  Loss operator()(double r2) const {
    const double width2 = width * width;
    if (!(r2 < width2)) return {width2 / 6, 0, 0};
    const double u = 1 - r2 / width2;
    return {width2 / 6 * (1 - u * u * u), u * u, u * (5 * u - 4)};
  }
};

RobustFit fit_huber_tukey(const WhitenedCorrespondences& c, const Pose& start,
                          const LspeOptions& options) {
  RobustFit huber = fit_huber(c, start, options);
  if (huber.status == PoseStatus::kBehindCamera) return huber;
  RobustFit tukey = minimise_loss(c, huber.cam_from_centred, TukeyLoss{kTukeyWidth * huber.sigma},
                                  kLimitFactor * options.max_iterations, options.step_tolerance);
  tukey.sigma = huber.sigma;
  tukey.iterations += huber.iterations;
  const bool is_determined =
      tukey.status == PoseStatus::kOk &&
      inverse_information(weighted_information(c, tukey.cam_from_centred, tukey.weights));
  return is_determined ? tukey : huber;
}

}  // namespace

PoseEstimate solve_huber_tukey(const PoseProblem& problem, const SolverOptions& options) {
  const PreparedWhitened prepared = prepare_whitened(problem);
  if (prepared.status != PoseStatus::kOk) return estimate_of_failure(prepared.status);
  const WhitenedCorrespondences& c = prepared.correspondences;
  const RobustFit fit =
      best_fit(starting_poses(c.points, problem.initial_cam_from_target),
               [&](const Pose& start) { return fit_huber_tukey(c, start, options.lspe); });
  const double t2 = squared_threshold(options.outliers.false_alarm_rate, c.size());
  return estimate_from_fit(fit, c, TukeyLoss{kTukeyWidth}(t2).weight);
}

}  // namespace sightline
