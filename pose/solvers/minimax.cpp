// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The minimax pose of all points, f_i = (u~_i - u_i)^2 + (v~_i - v_i)^2:
//
//   (theta, T) = arg min max_i f_i
//
// R. Hartley, F. Schaffalitzky: "L-infinity minimization in geometric reconstruction problems",
// CVPR 2004; criterion (5) of the ORPE paper (pose/solvers/orpe.cpp). Nothing is removed.
//
// Needs four points that are not collinear, or three with an initial pose. kDiverged when the
// maximum is not proven to be within kMinimaxGap of the least one near it.
//
// Deviations and choices: Hartley and Schaffalitzky find global minima of problems that are
// quasi-convex; a pose with its rotation is not. This is the exact minimum near the LSPE solution
// (pose/minimax.h); every start is carried to the end and the lowest maximum wins. Covariances of
// pixels are ignored, as in the ORPE paper.

#include "pose/minimax.h"

#include "pose/fit_points.h"
#include "pose/reprojection.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {

PoseEstimate solve_minimax(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate;
  const PreparedProblem prepared = prepare(problem);
  estimate.status = prepared.status;
  if (estimate.status != PoseStatus::kOk) return estimate;

  const Correspondences& c = prepared.correspondences;
  const FitPoints points = {c, {}, {}};
  const Minimax fit = minimax(points, starting_poses(c, problem.initial_cam_from_target), options);
  estimate.status = fit.status;
  estimate.iterations = fit.iterations;
  if (estimate.status != PoseStatus::kOk) return estimate;
  return with_minimax_pose(std::move(estimate), points, fit.cam_from_centred);
}

}  // namespace sightline
