// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The oracle: LSPE (pose/solvers/lspe.cpp) on the true inliers alone. It is told what every other
// solver has to find out, sits on the Cramér-Rao bound, and shows what an error costs that no
// choice of points could have avoided.
//
// Needs true_inliers, one a point, at least four of them true, or three with an initial pose;
// else kTooFewPoints.

#include "pose/solvers/solvers.h"

namespace sightline {

PoseEstimate solve_oracle(const PoseProblem& problem, const SolverOptions& options) {
  const std::size_t n = problem.points_in_target.size();
  if (problem.true_inliers.size() != n || problem.pixels.size() != n) return {};

  PoseProblem inliers;
  inliers.camera = problem.camera;
  inliers.initial_cam_from_target = problem.initial_cam_from_target;
  std::vector<int> removed;
  for (std::size_t i = 0; i < n; ++i) {
    if (!problem.true_inliers[i]) {
      removed.push_back(static_cast<int>(i));
      continue;
    }
    inliers.points_in_target.push_back(problem.points_in_target[i]);
    inliers.pixels.push_back(problem.pixels[i]);
  }
  PoseEstimate estimate = solve_lspe(inliers, options);
  estimate.removed = removed;
  return estimate;
}

}  // namespace sightline
