// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/minimax.h"

#include <cmath>
#include <string_view>

#include <gtest/gtest.h>

#include "pose/reprojection.h"
#include "pose/solver.h"
#include "tests/pose/matchers.h"
#include "tests/pose/solvers/solving.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

TEST(MinimaxSolver, HasASmallerMaximumThanLeastSquaresAndALargerSum) {
  Draw draw(15);
  for (int i = 0; i < 50; ++i) {
    const PoseProblem problem = cube_problem(1, draw).problem;
    const PoseEstimate estimate = find_pose_solver("minimax")->solve(problem, {});
    const PoseEstimate lspe = find_pose_solver("lspe")->solve(problem, {});
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    EXPECT_TRUE(estimate.removed.empty());
    const Correspondences c = prepare(problem).correspondences;
    const Pose pose = to_centred(estimate.cam_from_target, c);
    const Pose lspe_pose = to_centred(lspe.cam_from_target, c);
    EXPECT_LT(largest_px2(c, pose), largest_px2(c, lspe_pose));
    double sum = 0, lspe_sum = 0;
    for (std::size_t k = 0; k < 8; ++k) {
      sum += residual_px(c, k, pose)->squaredNorm();
      lspe_sum += residual_px(c, k, lspe_pose)->squaredNorm();
    }
    EXPECT_GT(sum, lspe_sum);
  }
}

TEST(MinimaxSolver, IsTheLimitOfTheEntropyFunction) {
  Draw draw(16);
  SolverOptions keep_all;
  keep_all.orpe.rho = kInfinity;
  for (int i = 0; i < 50; ++i) {
    Synthetic s = cube_problem(1, draw);
    if (i % 2) add_outlier(s.problem, 0, 20, draw);
    const Correspondences c = prepare(s.problem).correspondences;
    const auto largest = [&](std::string_view name) {
      const PoseEstimate e = find_pose_solver(name)->solve(s.problem, keep_all);
      return largest_px2(c, to_centred(e.cam_from_target, c));
    };
    EXPECT_LE(largest("minimax"), largest("orpe") * (1 + kMinimaxGap));
    EXPECT_LE(largest("orpe"), largest("minimax") * (1 + 1.1 * std::log(8.0) / 512));
  }
}

}  // namespace
}  // namespace sightline
