// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Problems that have broken solvers elsewhere: consensus gives what each is expected to give. Where
// another solver is known to fail, the same problem is its negative twin.
#include <algorithm>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/pose/consensus/case_file.h"
#include "tests/pose/solvers/solving.h"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Pixels of exact data are rounded to 1e-13 px.
constexpr double kExactPx = 1e-9;

/// The largest error of the points that are neither removed nor ignored.
double largest_kept_error_px(const PoseProblem& problem, const PoseEstimate& estimate) {
  double largest = 0;
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    const int index = static_cast<int>(i);
    if (std::ranges::count(estimate.removed, index) > 0) continue;
    if (std::ranges::count(estimate.ignored, index) > 0) continue;
    largest = std::max(largest, std::sqrt(squared_error_px2(problem, i, estimate.cam_from_target)));
  }
  return largest;
}

struct Solved {
  PoseProblem problem;
  PoseEstimate estimate;
};

Solved solved(const std::string& name, std::string_view solver = "consensus") {
  Solved s;
  s.problem = read_case(name);
  s.estimate = solve(solver, s.problem);
  return s;
}

TEST(ConsensusCases, FarPointOfTheTargetIsRemoved) {
  const Solved s = solved("01_one_far_3d_point");
  ASSERT_EQ(s.estimate.status, PoseStatus::kOk);
  EXPECT_THAT(s.estimate.removed, ElementsAre(0));
  EXPECT_LT(largest_kept_error_px(s.problem, s.estimate), kExactPx);
}

TEST(ConsensusCases, PixelThatCannotBeUsedIsIgnored) {
  for (const char* const name : {"02_nan_pixel", "03_pixel_beyond_lens_fold"}) {
    const Solved s = solved(name);
    ASSERT_EQ(s.estimate.status, PoseStatus::kOk) << name;
    EXPECT_THAT(s.estimate.ignored, ElementsAre(0)) << name;
    EXPECT_THAT(s.estimate.removed, IsEmpty()) << name;
    EXPECT_LT(largest_kept_error_px(s.problem, s.estimate), kExactPx) << name;
    EXPECT_EQ(s.estimate.inlier_probabilities.value()[0], 0) << name;
    EXPECT_NE(solved(name, "lspe").estimate.status, PoseStatus::kOk) << name;
  }
}

TEST(ConsensusCases, InitialPoseDoesNoHarm) {
  for (const char* const name : {"04_initial_float32", "05_initial_identity",
                                 "06_square_initial_mirror", "08_pp_off_image"}) {
    const Solved s = solved(name);
    ASSERT_EQ(s.estimate.status, PoseStatus::kOk) << name;
    EXPECT_THAT(s.estimate.removed, IsEmpty()) << name;
    EXPECT_LT(largest_kept_error_px(s.problem, s.estimate), kExactPx) << name;
  }
  // A solver that stays where it is put.
  const Solved stuck = solved("06_square_initial_mirror", "lspe");
  EXPECT_GT(largest_kept_error_px(stuck.problem, stuck.estimate), 0.01);
}

TEST(ConsensusCases, ThreeDifferentPointsDetermineNoPose) {
  EXPECT_EQ(solved("07_three_distinct").estimate.status, PoseStatus::kDegenerate);
}

/// Five of 13 points and 16 of 40 in a plane are outliers; the noise is 0.5 px.
TEST(ConsensusCases, ManyOutliersAreRemoved) {
  Pose truth;
  truth.rotation << 0.90239341, -0.24903648, -0.35166311, 0.13190856, 0.93655574, -0.32475144,
      0.41022703, 0.24666618, 0.87799180;
  truth.translation << 0.1, -0.2, 6;
  /// A pixel is 1/800 rad, a point's lever 1/6 of the range: 0.5 px of noise on eight points.
  constexpr double kToleranceRad = 0.01, kToleranceM = 0.03;
  for (const auto& [name, outliers] :
       {std::pair("09_13points_5outliers", 5), std::pair("10_planar_40_16outliers", 16)}) {
    const Solved s = solved(name);
    ASSERT_EQ(s.estimate.status, PoseStatus::kOk) << name;
    std::vector<int> expected;
    for (int i = 0; i < outliers; ++i) expected.push_back(i);
    EXPECT_EQ(s.estimate.removed, expected) << name;
    EXPECT_FALSE(is_test_failed(s.estimate)) << name;
    EXPECT_TRUE(s.estimate.diagnosis->is_significant.value()) << name;
    const Pose& pose = s.estimate.cam_from_target;
    EXPECT_LT((pose.rotation - truth.rotation).cwiseAbs().maxCoeff(), kToleranceRad) << name;
    EXPECT_LT((pose.translation - truth.translation).norm(), kToleranceM) << name;
  }
  const Solved other = solved("09_13points_5outliers", "lspe");
  EXPECT_GT((other.estimate.cam_from_target.translation - truth.translation).norm(), kToleranceM);
}

TEST(ConsensusCases, FrontalPlaneIsExactAndWhole) {
  for (const char* const name : {"fronto_5c", "fronto_5s"}) {
    const Solved s = solved(name);
    ASSERT_EQ(s.estimate.status, PoseStatus::kOk) << name;
    EXPECT_THAT(s.estimate.removed, IsEmpty()) << name;
    EXPECT_LT(largest_kept_error_px(s.problem, s.estimate), kExactPx) << name;
  }
}

}  // namespace
}  // namespace sightline
