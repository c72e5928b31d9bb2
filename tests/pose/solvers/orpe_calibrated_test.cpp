// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pose/solver.h"
#include "tests/pose/matchers.h"
#include "tests/pose/solvers/solving.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(OrpeCalibrated, LosesAGoodPointAsOftenAsStated) {
  constexpr int kTrials = 1500;
  for (const double rate : {0.1, 0.02}) {
    for (const double known_sigma_px : {0.0, 1.0}) {
      SolverOptions options;
      options.outliers.false_alarm_rate = rate;
      Draw draw(1);
      int removed = 0;
      for (int i = 0; i < kTrials; ++i) {
        Synthetic s = cube_problem(1, draw);
        s.problem.sigma_px = known_sigma_px;
        const PoseEstimate estimate = solve("orpe_calibrated", s.problem, options);
        ASSERT_EQ(estimate.status, PoseStatus::kOk);
        removed += !estimate.removed.empty();
      }
      const double sd = std::sqrt(rate / kTrials);
      EXPECT_NEAR(removed / double(kTrials), rate, 4 * sd + 0.3 * rate) << "sd " << known_sigma_px;
    }
  }
}

// The reason for testing outward: rho = 10 inward stops at the first of two.
TEST(OrpeCalibrated, FindsTwoOutliersThatMaskEachOther) {
  constexpr int kTrials = 200;
  for (const double known_sigma_px : {0.0, 0.3}) {
    Draw draw(2);
    int found = 0;
    int found_inward = 0;
    for (int i = 0; i < kTrials; ++i) {
      Synthetic s = cube_problem(0.3, draw);
      s.problem.sigma_px = known_sigma_px;
      add_outlier(s.problem, 1, draw.uniform(15, 30), draw);
      add_outlier(s.problem, 6, draw.uniform(15, 30), draw);
      found += solve("orpe_calibrated", s.problem).removed == std::vector<int>{1, 6};
      found_inward +=
          find_pose_solver("orpe")->solve(s.problem, {}).removed == std::vector<int>{1, 6};
    }
    EXPECT_GE(found, 0.75 * kTrials);
    EXPECT_LE(found_inward, 0.1 * kTrials);
  }
}

TEST(OrpeCalibrated, GivesTheOraclesPoseWhenItFindsTheOutlier) {
  Draw draw(3);
  int found = 0;
  for (int i = 0; i < 50; ++i) {
    Synthetic s = cube_problem(0.5, draw);
    s.problem.sigma_px = 0.5;
    const int outlier = draw.index(8);
    add_outlier(s.problem, outlier, 30, draw);
    const PoseEstimate estimate = solve("orpe_calibrated", s.problem);
    const PoseEstimate oracle = find_pose_solver("oracle")->solve(s.problem, {});
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    EXPECT_FALSE(is_test_failed(estimate));
    if (estimate.removed != oracle.removed) continue;
    ++found;
    EXPECT_TRUE(is_pose_near(estimate.cam_from_target, oracle.cam_from_target, 1e-7, 1e-4));
  }
  EXPECT_GE(found, 48);
}

TEST(OrpeCalibrated, RemovesNoMoreThanItMay) {
  Draw draw(4);
  for (int i = 0; i < 100; ++i) {
    Synthetic s = cube_problem(0.3, draw);
    for (const int k : {0, 3, 5}) add_outlier(s.problem, k, 25, draw);
    for (const int most : {0, 1, 2, 3}) {
      SolverOptions options;
      options.outliers.max_removed = most;
      const PoseEstimate estimate = solve("orpe_calibrated", s.problem, options);
      EXPECT_LE(estimate.removed.size(), static_cast<std::size_t>(most));
      EXPECT_TRUE(std::ranges::is_sorted(estimate.removed));
      EXPECT_TRUE(is_free_of_nan(estimate));
    }
  }
}

TEST(OrpeCalibrated, SaysWhenWhatIsKeptIsNoNoise) {
  Draw draw(5);
  SolverOptions one;
  one.outliers.max_removed = 1;
  for (int i = 0; i < 20; ++i) {
    Synthetic s = cube_problem(0.3, draw);
    s.problem.sigma_px = 0.3;
    add_outlier(s.problem, 0, 30, draw);
    add_outlier(s.problem, 7, 30, draw);
    EXPECT_TRUE(is_test_failed(solve("orpe_calibrated", s.problem, one)));
    s.problem.sigma_px = 0;  // nothing to compare with, and nothing is said
    SolverOptions unjudged = one;
    unjudged.is_judged = false;
    EXPECT_FALSE(solve("orpe_calibrated", s.problem, unjudged).diagnosis.value().is_test_failed);
  }
}

TEST(OrpeCalibrated, FindsOutliersAmongExactPoints) {
  Draw draw(6);
  for (const double known_sigma_px : {0.0, 1e-9}) {
    int found = 0;
    for (int i = 0; i < 50; ++i) {
      Synthetic s = cube_problem(0, draw);
      s.problem.sigma_px = known_sigma_px;
      EXPECT_THAT(solve("orpe_calibrated", s.problem).removed, IsEmpty());
      add_outlier(s.problem, 2, 20, draw);
      const PoseEstimate estimate = solve("orpe_calibrated", s.problem);
      if (estimate.removed != std::vector<int>{2}) continue;
      ++found;
      EXPECT_TRUE(is_pose_near(estimate.cam_from_target, s.cam_from_target, 1e-8, 1e-5));
    }
    EXPECT_GE(found, 48);
  }
}

TEST(OrpeCalibrated, NoiseThatIsNoNumberSaysSo) {
  Draw draw(7);
  PoseProblem problem = cube_problem(1, draw).problem;
  for (const double bad : {-1.0, kNaN, kInfinity}) {
    problem.sigma_px = bad;
    const PoseEstimate estimate = solve("orpe_calibrated", problem);
    EXPECT_EQ(estimate.status, PoseStatus::kDegenerate);
    EXPECT_TRUE(is_free_of_nan(estimate));
  }
}

TEST(OrpeCalibrated, KeepsAPointWithoutWhichTheOthersAreCollinear) {
  Draw draw(8);
  Synthetic s = exact_problem(centred_camera(512, 512, 5000),
                              {{-1, 0, 0}, {-0.3, 0, 0}, {0.4, 0, 0}, {1, 0, 0}, {0, 1, 0.2}},
                              {draw.rotation_by(0.5), {0, 0, 50}});
  add_outlier(s.problem, 4, 30, draw);
  const PoseEstimate estimate = solve("orpe_calibrated", s.problem);
  EXPECT_TRUE(is_free_of_nan(estimate));
  EXPECT_FALSE(std::ranges::count(estimate.removed, 4));
}

}  // namespace
}  // namespace sightline
