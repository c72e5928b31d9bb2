// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What solver_test.cpp does not say of ORPE: its option for the final pose.
#include <gtest/gtest.h>

#include "pose/reprojection.h"
#include "pose/solver.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

PoseEstimate solve(std::string_view name, const PoseProblem& problem,
                   const SolverOptions& options = {}) {
  return find_pose_solver(name)->solve(problem, options);
}

TEST(Orpe, FinalLeastSquaresIsTheOraclesPoseWhenItRemovesTheOutlier) {
  Draw draw(1);
  SolverOptions least_squares_last;
  least_squares_last.orpe.final = OrpeOptions::Final::kLeastSquares;
  for (int i = 0; i < 50; ++i) {
    Synthetic s = cube_problem(0.3, draw);
    const int outlier = draw.index(8);
    add_outlier(s.problem, outlier, 30, draw);
    const PoseEstimate minimax = solve("orpe", s.problem);
    const PoseEstimate squares = solve("orpe", s.problem, least_squares_last);
    const PoseEstimate oracle = solve("oracle", s.problem);
    ASSERT_EQ(squares.status, PoseStatus::kOk);
    EXPECT_EQ(squares.removed, minimax.removed);
    if (squares.removed != std::vector<int>{outlier}) continue;
    EXPECT_TRUE(is_pose_near(squares.cam_from_target, oracle.cam_from_target, 1e-7, 1e-4));
    EXPECT_TRUE(is_matrix_near(squares.unit_covariance, oracle.unit_covariance,
                               1e-5 * oracle.unit_covariance.norm()));
    EXPECT_FALSE(is_pose_near(minimax.cam_from_target, oracle.cam_from_target, 1e-7, 1e-4));
  }
}

}  // namespace
}  // namespace sightline
