// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/pose/consensus/case_file.h"
#include "tests/pose/consensus/scenes.h"
#include "tests/pose/solvers/solving.h"

namespace sightline {
namespace {

using testing::ElementsAre;

std::vector<int> first(int count) {
  std::vector<int> indices;
  for (int i = 0; i < count; ++i) indices.push_back(i);
  return indices;
}

/// Outliers of 15 px are far beyond the bound, which one set of pure noise in a hundred exceeds.
TEST(OrpeConsensus, RemovesExactlyTheGrossOutliers) {
  constexpr int kDraws = 30;
  for (const auto& [points, outliers] : {std::pair(12, 4), {50, 25}, {200, 180}}) {
    Draw draw(20);
    int exact = 0;
    for (int i = 0; i < kDraws; ++i) {
      Synthetic s = scene({points, outliers, i % 2 == 0, 1}, draw);
      s.problem.sigma_px = 1;
      const PoseEstimate estimate = solve("orpe_consensus", s.problem);
      ASSERT_EQ(estimate.status, PoseStatus::kOk);
      exact += estimate.removed == first(outliers);
      EXPECT_FALSE(is_test_failed(estimate));
      EXPECT_LT(squared_distance_from_truth(estimate.cam_from_target, s, 1), 60);
    }
    EXPECT_GE(exact, kDraws - 3) << points;
  }
}

/// The negative twin: the paper's way, which starts from all points, does not.
TEST(OrpeConsensus, DoesWhatOrpeDoesNot) {
  Draw draw(21);
  int exact = 0;
  for (int i = 0; i < 10; ++i) {
    exact += solve("orpe", scene({12, 4, false, 1}, draw).problem).removed == first(4);
  }
  EXPECT_LT(exact, 5);
}

TEST(OrpeConsensus, LeavesOutWhatConsensusLeavesOut) {
  const PoseProblem nan = read_case("02_nan_pixel");
  const PoseEstimate estimate = solve("orpe_consensus", nan);
  ASSERT_EQ(estimate.status, PoseStatus::kOk);
  EXPECT_THAT(estimate.ignored, ElementsAre(0));
  EXPECT_TRUE(estimate.removed.empty());
  const PoseEstimate far = solve("orpe_consensus", read_case("01_one_far_3d_point"));
  ASSERT_EQ(far.status, PoseStatus::kOk);
  EXPECT_THAT(far.removed, ElementsAre(0));
}

TEST(OrpeConsensus, CovarianceIsThatOfTheNoise) {
  Draw draw(22);
  const Synthetic s = scene({30, 10, false, 2}, draw);
  PoseProblem known = s.problem;
  known.sigma_px = 2;
  const PoseEstimate a = solve("orpe_consensus", known);
  EXPECT_TRUE(is_matrix_near(*a.covariance, 4 * a.unit_covariance, 1e-9 * a.covariance->norm()));
  const PoseEstimate b = solve("orpe_consensus", s.problem);
  // Twenty pairs say what the noise is to a tenth.
  EXPECT_NEAR(*b.noise_px, 2, 0.8);
}

}  // namespace
}  // namespace sightline
