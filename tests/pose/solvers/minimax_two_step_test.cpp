// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "pose/reprojection.h"
#include "pose/solver.h"
#include "tests/pose/matchers.h"
#include "tests/pose/solvers/solving.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

/// What the last round may still have gained, and the gap of its steps.
constexpr double kRoundRelative = 2e-5;

struct Fit {
  Correspondences c;
  Pose cam_from_centred;
  double largest_px2 = 0;
};

Fit fit(std::string_view solver, const PoseProblem& problem) {
  const PoseEstimate estimate = find_pose_solver(solver)->solve(problem, {});
  EXPECT_EQ(estimate.status, PoseStatus::kOk);
  EXPECT_TRUE(estimate.removed.empty());
  Fit result;
  result.c = prepare(problem).correspondences;
  result.cam_from_centred = to_centred(estimate.cam_from_target, result.c);
  result.largest_px2 = largest_px2(result.c, result.cam_from_centred);
  return result;
}

TEST(MinimaxTwoStep, NeitherATurnNorAMoveAloneLowersTheMaximum) {
  Draw draw(1);
  for (int i = 0; i < 20; ++i) {
    const Fit f = fit("minimax_two_step", cube_problem(1, draw).problem);
    const double range = f.cam_from_centred.translation.norm();
    for (int k = 0; k < 300; ++k) {
      const double size = std::pow(10, draw.uniform(-6, -1));
      Vector6d turn = Vector6d::Zero();
      Vector6d move = Vector6d::Zero();
      turn.head<3>() = size * draw.vector();
      move.tail<3>() = size * 0.1 * range * draw.vector();
      for (const Vector6d& delta : {turn, move}) {
        EXPECT_GE(largest_px2(f.c, retract(f.cam_from_centred, delta)),
                  f.largest_px2 * (1 - kRoundRelative));
      }
    }
  }
}

// What its file says of ridges: both together lower it.
TEST(MinimaxTwoStep, StopsAboveTheJointMinimax) {
  constexpr int kTrials = 100;
  Draw draw(2);
  int above = 0;
  for (int i = 0; i < kTrials; ++i) {
    const PoseProblem problem = cube_problem(1, draw).problem;
    const double joint_px2 = fit("minimax", problem).largest_px2;
    const double two_step_px2 = fit("minimax_two_step", problem).largest_px2;
    EXPECT_GE(two_step_px2, joint_px2 * (1 - kRoundRelative));
    EXPECT_LE(two_step_px2, fit("lspe", problem).largest_px2 * (1 + kRoundRelative));
    above += two_step_px2 > 1.01 * joint_px2;
  }
  EXPECT_GE(above, kTrials / 2);
}

}  // namespace
}  // namespace sightline
