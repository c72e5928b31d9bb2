// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pose/solver.h"
#include "tests/pose/matchers.h"
#include "tests/pose/solvers/solving.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

using testing::ElementsAre;

TEST(Oracle, IsLeastSquaresOnTheTrueInliers) {
  Draw draw(34);
  Synthetic s = cube_problem(1, draw);
  add_outlier(s.problem, 1, 30, draw);
  add_outlier(s.problem, 6, 20, draw);
  const PoseEstimate oracle = solve("oracle", s.problem);
  ASSERT_EQ(oracle.status, PoseStatus::kOk);
  EXPECT_THAT(oracle.removed, ElementsAre(1, 6));

  PoseProblem rest = s.problem;
  for (const int i : {6, 1}) {
    rest.points_in_target.erase(rest.points_in_target.begin() + i);
    rest.pixels.erase(rest.pixels.begin() + i);
  }
  const PoseEstimate lspe = solve("lspe", rest);
  EXPECT_TRUE(is_pose_near(oracle.cam_from_target, lspe.cam_from_target, 0, 0));
}

TEST(Oracle, NeedsTheMaskAndFourTrueInliers) {
  Draw draw(35);
  PoseProblem problem = cube_problem(1, draw).problem;
  problem.true_inliers = {true, true, true, true, false, false, false, false};
  EXPECT_NE(solve("oracle", problem).status, PoseStatus::kTooFewPoints);
  problem.true_inliers = {true, true, true, false, false, false, false, false};
  EXPECT_EQ(solve("oracle", problem).status, PoseStatus::kTooFewPoints);
  problem.true_inliers = {true, true, true, true};
  EXPECT_EQ(solve("oracle", problem).status, PoseStatus::kTooFewPoints);
  problem.true_inliers.clear();
  EXPECT_EQ(solve("oracle", problem).status, PoseStatus::kTooFewPoints);
}

}  // namespace
}  // namespace sightline
