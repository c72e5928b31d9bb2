// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/minimax.h"

#include <cmath>
#include <string_view>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "pose/minimax_null.h"
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

/// NEES by the minimax's own covariance is that of six degrees of freedom; by that of least
/// squares, which is the smaller the more points there are, it is not.
TEST(MinimaxSolver, CovarianceIsItsOwn) {
  Draw draw(17);
  constexpr int kDraws = 300;
  constexpr double kSigmaPx = 0.3;
  /// The mean of 300 draws of chi-square with six degrees has a standard deviation of 0.2; the law
  /// of the minimax's errors is somewhat heavier, and the factor is right within 5 %.
  constexpr double kTolerance = 1.2;
  for (const int n : {8, 30}) {
    double sum = 0;
    for (int i = 0; i < kDraws; ++i) {
      Synthetic s = exact_problem(centred_camera(640, 480, 800), points_in_box(n, {1, 1, 1}, draw),
                                  {draw.rotation(), {0, 0, 6}});
      add_noise(s.problem, kSigmaPx, draw);
      const PoseEstimate e = find_pose_solver("minimax")->solve(s.problem, {});
      ASSERT_EQ(e.status, PoseStatus::kOk);
      Vector6d error;
      error << vector_from_rotation(e.cam_from_target.rotation *
                                    s.cam_from_target.rotation.transpose()),
          e.cam_from_target.translation - s.cam_from_target.translation;
      sum += error.dot(e.unit_covariance.inverse() * error) / (kSigmaPx * kSigmaPx);
    }
    EXPECT_NEAR(sum / kDraws, 6, kTolerance) << n;
    EXPECT_GT(sum / kDraws * minimax_variance_factor(n), 6 + kTolerance) << n;
  }
}

}  // namespace
}  // namespace sightline
