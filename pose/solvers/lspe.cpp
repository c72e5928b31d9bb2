// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// LSPE, least-squares pose estimation:
//
//   (theta, T) = arg min sum_i (u~_i - u_i)^2 + (v~_i - v_i)^2
//
// Zhao, Zhang, Zuo, Xu: "A method of improving the measuring accuracy of the pose of targets based
// on outliers-removal", Acta Optica Sinica 29(9), 2009, equations (1) to (4).
//
// Needs four points that are not collinear, or three with an initial pose (three points have up to
// four solutions; the one that the start leads to is taken), and every pixel within what the lens
// model can undo. Without an initial pose it starts from orthogonal iteration; every start is
// carried to the end and the lowest cost wins.
//
// Deviations: the paper leaves the optimiser open. This one is Marquardt's, with the analytic
// derivative by a rotation vector applied from the left rather than by three angles, which would
// lock at 90 degrees of yaw. Residuals are those of the undistorted pixels (the paper's camera has
// no distortion). Covariances of pixels are ignored, as in the paper.

#include <cmath>

#include "pose/reprojection.h"
#include "pose/solvers/solvers.h"

namespace sightline {
namespace {

/// Half the sum of squares, J^T r and J^T J. None when a point is behind the camera.
std::optional<LocalModel> gauss_newton_model(const Correspondences& c,
                                             std::span<const double> weights, const Pose& pose) {
  LocalModel model;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const double weight = weights.empty() ? 1.0 : weights[i];
    if (weight == 0) continue;
    const std::optional<Reprojection> r = reproject(c, i, pose);
    if (!r) return std::nullopt;
    model.cost += 0.5 * weight * r->residual_px.squaredNorm();
    model.gradient.noalias() += weight * r->jacobian.transpose() * r->residual_px;
    model.hessian.noalias() += weight * r->jacobian.transpose() * r->jacobian;
  }
  return model;
}

/// Of two outcomes the one to keep: success before failure, then the lower cost.
bool is_preferable(const Minimum& a, const Minimum& b) {
  if (a.status != b.status) return a.status == PoseStatus::kOk;
  return a.model.cost < b.model.cost;
}

}  // namespace

LeastSquares least_squares(const Correspondences& c, std::span<const Pose> cam_from_centred_starts,
                           const LspeOptions& options, std::span<const double> weights) {
  LeastSquares result;
  if (cam_from_centred_starts.empty()) {
    result.status = PoseStatus::kDegenerate;
    return result;
  }
  const auto evaluate = [&](const Pose& pose) { return gauss_newton_model(c, weights, pose); };
  std::optional<Minimum> best;
  for (const Pose& start : cam_from_centred_starts) {
    const Minimum minimum =
        minimise(start, evaluate, options.max_iterations, options.step_tolerance);
    result.iterations += minimum.iterations;
    if (!best || is_preferable(minimum, *best)) best = minimum;
  }
  result.status = best->status;
  result.cam_from_centred = best->pose;
  result.cost_px2 = 2 * best->model.cost;
  if (result.status != PoseStatus::kOk) return result;

  const std::optional<Matrix6d> covariance = inverse_information(best->model.hessian);
  if (covariance) result.unit_covariance = *covariance;
  if (!covariance) result.status = PoseStatus::kDegenerate;
  return result;
}

PoseEstimate solve_lspe(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate;
  const PreparedProblem prepared = prepare(problem);
  estimate.status = prepared.status;
  if (estimate.status != PoseStatus::kOk) return estimate;

  const Correspondences& c = prepared.correspondences;
  const LeastSquares solution =
      least_squares(c, starting_poses(c, problem.initial_cam_from_target), options.lspe);
  estimate.status = solution.status;
  estimate.iterations = solution.iterations;
  if (estimate.status != PoseStatus::kOk) return estimate;

  estimate.cam_from_target = from_centred(solution.cam_from_centred, c);
  estimate.unit_covariance =
      covariance_from_centred(solution.unit_covariance, solution.cam_from_centred, c);
  return estimate;
}

}  // namespace sightline
