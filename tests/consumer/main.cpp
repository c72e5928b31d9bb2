// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>

#include <pose/solver.h>

int main() {
  // The corners of a cube, 1 m wide and 20 m away, and where a camera saw them: one badly.
  sightline::PoseProblem problem;
  problem.camera = sightline::centred_camera(512, 512, 4000);  // width, height, focal length: px
  problem.sigma_px = 0.5;                                      // of the pixels' noise, if known
  const Eigen::Vector2d seen_px[] = {{220.5, 186.9}, {171.6, 118.4}, {170.7, 376.9},
                                     {137.7, 290.9}, {412.5, 216.6}, {356.0, 147.6},
                                     {360.5, 403.3}, {307.6, 326.2}};
  for (int i = 0; i < 8; ++i) {
    const double x = i & 4 ? 0.5 : -0.5, y = i & 2 ? 0.5 : -0.5, z = i & 1 ? 0.5 : -0.5;
    problem.points_in_target.emplace_back(x, y, z);
    problem.pixels.push_back(seen_px[i]);
  }

  const sightline::PoseSolver* const solver = sightline::find_pose_solver("orpe_weighed");
  const sightline::PoseEstimate estimate = solver->solve(problem, {});
  if (estimate.status != sightline::PoseStatus::kOk) return 1;

  const Eigen::Vector3d& t = estimate.cam_from_target.translation;
  const double range_sd = std::sqrt((*estimate.covariance)(5, 5));
  std::printf("target at (%.2f, %.2f, %.2f) m, sd %.2f in z\n", t.x(), t.y(), t.z(), range_sd);
  for (const int i : estimate.removed) {
    std::printf("point %d was seen badly\n", i);
  }
  return 0;
}
