// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The minimax pose by two alternating steps, f_i the squared reprojection error of point i:
//
//   1. theta = arg min over theta of max_i f_i(theta, T), T fixed
//   2. T = arg min over T of max_i f_i(theta, T), theta fixed
//   3. Unless the maximum has stopped falling, go to 1.
//
// After X. Zhang: "Pose estimation using L-infinity", Image and Vision Computing New Zealand, 2005,
// of which the ORPE paper (pose/solvers/orpe.cpp) says that it solves position and attitude in two
// steps under the minimax criterion, ORPE both at once. Zhang's paper was not at hand: the
// alternation, and its start, are our reading.
//
// Needs four points that are not collinear, or three with an initial pose. With theta fixed the
// maximum is quasi-convex in T (Hartley and Schaffalitzky, CVPR 2004): step 2 is a global minimum.
// Step 1 is one near its start only.
//
// Where it falls short: the maximum has ridges. On one of them no change of theta alone and none of
// T alone lowers it, while a joint one does: the alternation stops there, above the minimax of
// pose/solvers/minimax.cpp (on a cube by 5 to 50 % in squared pixels). That is kOk here. Along a
// ridge it may creep; kDiverged after kMaxRounds.
//
// Choices: T is the position of the points' centroid, so that the choice of the target's frame does
// not matter. It starts from the LSPE solution; each start is carried to the end and the lowest
// maximum wins. Covariances of pixels are ignored.

#include <limits>
#include <optional>

#include "pose/fit_points.h"
#include "pose/minimax.h"
#include "pose/reprojection.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {
namespace {

constexpr int kMaxRounds = 500;
constexpr double kLeastFall = 1e-5;  ///< of the maximum, in a round that is worth another

Minimax alternate(const FitPoints& points, const Pose& cam_from_centred_start) {
  Minimax current;
  current.cam_from_centred = cam_from_centred_start;
  current.largest_px2 = std::numeric_limits<double>::infinity();
  int iterations = 0;
  for (int round = 0; round < kMaxRounds; ++round) {
    const double before_px2 = current.largest_px2;
    for (const FreePart part : {FreePart::kRotation, FreePart::kTranslation}) {
      MinimaxOptions step_options;
      step_options.free = part;
      Minimax step = minimax_from(points, current.cam_from_centred, step_options);
      iterations += step.iterations;
      if (step.status == PoseStatus::kBehindCamera) return step;
      // A step that fails, one in ten thousand, is left to the next round.
      if (step.status == PoseStatus::kOk && step.largest_px2 < current.largest_px2) {
        current = std::move(step);
      }
    }
    current.iterations = iterations;
    if (!(before_px2 - current.largest_px2 > kLeastFall * current.largest_px2)) return current;
  }
  current.status = PoseStatus::kDiverged;
  return current;
}

}  // namespace

PoseEstimate solve_minimax_two_step(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate;
  const PreparedProblem prepared = prepare(problem);
  estimate.status = prepared.status;
  if (estimate.status != PoseStatus::kOk) return estimate;

  const Correspondences& c = prepared.correspondences;
  const FitPoints points = {c, {}, {}};
  std::optional<Minimax> best;
  estimate.status = PoseStatus::kDegenerate;
  for (const Pose& start : starting_poses(c, problem.initial_cam_from_target)) {
    const LeastSquares begin = least_squares(points, {&start, 1}, options.lspe);
    estimate.iterations += begin.iterations;
    if (!best) estimate.status = begin.status;
    // Where least squares stopped is a start as good as another.
    const bool is_start = begin.status == PoseStatus::kOk || begin.status == PoseStatus::kDiverged;
    if (!is_start) continue;
    Minimax fit = alternate(points, begin.cam_from_centred);
    estimate.iterations += fit.iterations;
    if (!best) estimate.status = fit.status;
    if (fit.status != PoseStatus::kOk) continue;
    if (!best || fit.largest_px2 < best->largest_px2) best = std::move(fit);
  }
  if (!best) return estimate;
  estimate.status = PoseStatus::kOk;
  return with_minimax_pose(std::move(estimate), points, best->cam_from_centred);
}

}  // namespace sightline
