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
// model can undo. Without an initial pose it starts from the scaled-orthographic pose or from
// orthogonal iteration (starting_poses); every start is carried to the end and the lowest cost
// wins. An initial pose that turns out to have been more than 29 degrees off, or that leads
// nowhere, competes with those starts.
//
// Deviations: the paper leaves the optimiser open. This one is Marquardt's, with the analytic
// derivative by a rotation vector applied from the left rather than by three angles, which would
// lock at 90 degrees of yaw. Residuals are those of the undistorted pixels (the paper's camera has
// no distortion). Covariances of pixels are ignored, as in the paper.

#include "pose/least_squares.h"
#include "pose/reprojection.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {
namespace {

/// Beyond this turn a start is no guess at the minimum it led to: in one of some hundred clouds of
/// eight points that is a local one.
constexpr double kFarStartCosine = 0.8775825618903728;  // of 0.5 rad

bool has_gone_far(const LeastSquares& solution, const Pose& initial) {
  // The trace of the turn between two rotations is 1 + 2 cos.
  const double trace = solution.cam_from_centred.rotation.cwiseProduct(initial.rotation).sum();
  if (solution.status == PoseStatus::kDiverged) return true;
  return solution.status == PoseStatus::kOk && trace < 1 + 2 * kFarStartCosine;
}

LeastSquares better_of(const LeastSquares& first, const LeastSquares& second) {
  const bool is_second = second.status == PoseStatus::kOk &&
                         (first.status != PoseStatus::kOk || second.cost_px2 < first.cost_px2);
  LeastSquares better = is_second ? second : first;
  better.iterations = first.iterations + second.iterations;
  return better;
}

}  // namespace

PoseEstimate solve_lspe(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate;
  const PreparedProblem prepared = prepare(problem);
  estimate.status = prepared.status;
  if (estimate.status != PoseStatus::kOk) return estimate;

  const Correspondences& c = prepared.correspondences;
  LeastSquares solution =
      least_squares(c, starting_poses(c, problem.initial_cam_from_target), options.lspe);
  if (problem.initial_cam_from_target && c.size() >= kMinimumPosePoints &&
      has_gone_far(solution, *problem.initial_cam_from_target)) {
    const LeastSquares free = least_squares(c, starting_poses(c, std::nullopt), options.lspe);
    solution = better_of(solution, free);
  }
  estimate.status = solution.status;
  estimate.iterations = solution.iterations;
  if (estimate.status != PoseStatus::kOk) return estimate;

  estimate.cam_from_target = from_centred(solution.cam_from_centred, c);
  estimate.unit_covariance =
      covariance_from_centred(solution.unit_covariance, solution.cam_from_centred, c);
  return estimate;
}

}  // namespace sightline
