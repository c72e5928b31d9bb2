// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/entry/all_poses.h"

#include <algorithm>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/pose/matchers.h"
#include "tests/pose/solvers/solving.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

/// A pixel is 1/800 rad; exact pixels are rounded to 1e-13 px.
constexpr double kSamePoseRad = 1e-6;
constexpr double kSamePoseM = 1e-5;

Synthetic near_points(int n, double depth, Draw& draw) {
  return exact_problem(centred_camera(640, 480, 800), points_in_box(n, {1, 1, depth}, draw),
                       {draw.rotation(), {0.1, -0.2, 6}});
}

bool holds(const PoseMinima& minima, const Pose& pose) {
  return std::ranges::any_of(minima.minima, [&pose](const PoseMinimum& m) {
    return bool(is_pose_near(m.cam_from_target, pose, kSamePoseRad, kSamePoseM));
  });
}

TEST(SolveAll, ThreePointsHaveUpToFourPosesThatMeetThem) {
  Draw draw(1);
  std::size_t most = 0;
  for (int i = 0; i < 50; ++i) {
    const Synthetic s = near_points(3, 1, draw);
    const PoseMinima all = solve_all(s.problem);
    ASSERT_EQ(all.status, PoseStatus::kOk);
    EXPECT_TRUE(holds(all, s.cam_from_target));
    EXPECT_LE(all.minima.size(), 4u);
    for (const PoseMinimum& m : all.minima) {
      EXPECT_LT(m.cost, 1e-12);
      EXPECT_LT(largest_squared_error_px2(s.problem, m.cam_from_target), 1e-12);
    }
    most = std::max(most, all.minima.size());
  }
  EXPECT_GE(most, 2u);
}

TEST(SolveAll, PlaneFromAfarHasBothPosesEachLeastAmongThoseNearIt) {
  Draw draw(2);
  for (int i = 0; i < 10; ++i) {
    Synthetic s = exact_problem(centred_camera(640, 480, 8000), points_in_box(8, {1, 1, 0}, draw),
                                {rotation_from_vector({0.6, 0.3, 0.1}), {0.1, 0.2, 60}});
    add_noise(s.problem, 0.3, draw);
    const PoseMinima all = solve_all(s.problem);
    ASSERT_EQ(all.status, PoseStatus::kOk);
    ASSERT_GE(all.minima.size(), 2u);
    EXPECT_TRUE(std::ranges::is_sorted(all.minima, {}, &PoseMinimum::cost));
    const PoseEstimate lspe = solve("lspe", s.problem);
    EXPECT_TRUE(holds(all, lspe.cam_from_target));
    for (const PoseMinimum& m : all.minima) {
      EXPECT_NEAR(m.cost, sum_of_squares_px2(s.problem, m.cam_from_target), 1e-9 * m.cost);
      constexpr double kStepRad = 1e-4, kStepM = 1e-3;
      for (int k = 0; k < 20; ++k) {
        Vector6d step;
        step << kStepRad * draw.vector(), kStepM * draw.vector();
        EXPECT_GE(sum_of_squares_px2(s.problem, retract(m.cam_from_target, step)), m.cost);
      }
    }
    // The twin: a solid target near by has one pose that counts.
    const PoseMinima solid = solve_all(near_points(8, 1, draw).problem);
    ASSERT_EQ(solid.status, PoseStatus::kOk);
    EXPECT_LT(solid.minima[0].cost, 1e-12);
    if (solid.minima.size() > 1) {
      EXPECT_GT(solid.minima[1].cost, 1);
    }
  }
}

TEST(SolveAll, LeavesOutWhatItIsToldAndWhatCannotBeUsed) {
  Draw draw(3);
  Synthetic s = near_points(8, 1, draw);
  s.problem.pixels[1].x() = kNaN;
  add_outlier(s.problem, 4, 40, draw);
  const PoseMinima with_outlier = solve_all(s.problem);
  EXPECT_THAT(with_outlier.ignored, testing::ElementsAre(1));
  EXPECT_FALSE(holds(with_outlier, s.cam_from_target));
  const PoseMinima without = solve_all(s.problem, std::vector{4});
  EXPECT_TRUE(holds(without, s.cam_from_target));
  EXPECT_LT(without.minima[0].cost, 1e-12);
}

TEST(SolveAll, SaysWhyThereIsNone) {
  Draw draw(4);
  const Synthetic s = near_points(4, 1, draw);
  EXPECT_EQ(solve_all(first_points(s.problem, 2)).status, PoseStatus::kTooFewPoints);
  EXPECT_NE(solve_all(s.problem, std::vector{0, 1}).status, PoseStatus::kOk);
  PoseProblem line = s.problem;
  for (auto& x : line.points_in_target) x = Eigen::Vector3d(1, 2, 3) * draw.uniform(-0.3, 0.3);
  EXPECT_EQ(solve_all(line).status, PoseStatus::kDegenerate);
  EXPECT_TRUE(solve_all(line).minima.empty());
}

}  // namespace
}  // namespace sightline
