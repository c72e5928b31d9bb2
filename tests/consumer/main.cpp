// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include <pose/solver.h>

int main() {
  // Five points of a tetrahedron and its centre, seen exactly from 10 m.
  sightline::PoseProblem problem;
  problem.camera = sightline::centred_camera(512, 512, 1000);
  problem.points_in_target = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}, {0, 0, 0}};
  for (const Eigen::Vector3d& point : problem.points_in_target) {
    problem.pixels.push_back(
        *sightline::project(problem.camera, point + Eigen::Vector3d(0, 0, 10)));
  }
  const auto estimate = sightline::find_pose_solver("lspe")->solve(problem, {});
  const bool is_right =
      estimate.status == sightline::PoseStatus::kOk &&
      (estimate.cam_from_target.translation - Eigen::Vector3d(0, 0, 10)).norm() < 1e-6;
  return is_right ? 0 : 1;
}
