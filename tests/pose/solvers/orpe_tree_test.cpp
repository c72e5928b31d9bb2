// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pose/minimax.h"
#include "pose/minimax_null.h"
#include "pose/reprojection.h"
#include "pose/solver.h"
#include "tests/pose/matchers.h"
#include "tests/pose/solvers/solving.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr double kRate = 0.01;  ///< the default false-alarm rate

double minimax_px2(const Correspondences& c, const std::vector<int>& kept, const Pose& start) {
  const Minimax m = minimax({c, kept, {}}, {&start, 1}, {});
  return m.status == PoseStatus::kOk ? m.largest_px2 : kInfinity;
}

std::vector<int> complement(const std::vector<int>& removed, int n) {
  std::vector<int> kept;
  for (int i = 0; i < n; ++i) {
    if (!std::ranges::count(removed, i)) kept.push_back(i);
  }
  return kept;
}

/// The fewest removals that pass and the least minimax among them, by trying every set.
struct BruteForce {
  int removals = -1;  ///< -1: none passes
  double minimax_px2 = kInfinity;
};

BruteForce brute_force(const Synthetic& s, int most) {
  const Correspondences c = prepare(s.problem).correspondences;
  const int n = static_cast<int>(c.size());
  const Pose start = to_centred(s.cam_from_target, c);
  BruteForce best;
  for (int removals = 0; removals <= most && best.removals < 0; ++removals) {
    for (unsigned mask = 0; mask < 1u << n; ++mask) {
      if (std::popcount(mask) != removals) continue;
      std::vector<int> kept;
      for (int i = 0; i < n; ++i) {
        if (!(mask >> i & 1)) kept.push_back(i);
      }
      const double largest_px2 = minimax_px2(c, kept, start);
      const double allowed_px2 =
          s.problem.sigma_px * s.problem.sigma_px * minimax_quantile(kept.size(), kRate);
      if (largest_px2 > allowed_px2) continue;
      best.removals = removals;
      best.minimax_px2 = std::min(best.minimax_px2, largest_px2);
    }
  }
  return best;
}

TEST(OrpeTree, RemovesAsFewAsTryingEverySet) {
  constexpr int kTrials = 400;
  Draw draw(1);
  for (int i = 0; i < kTrials; ++i) {
    const int n = 6 + i % 3;
    std::vector<Eigen::Vector3d> points = cube_vertices();
    points.erase(points.begin(), points.begin() + (8 - n));
    Synthetic s = exact_problem(centred_camera(512, 512, 15000), points, cube_pose(draw));
    s.problem.sigma_px = draw.uniform(0.5, 3);
    add_noise(s.problem, s.problem.sigma_px, draw);
    const int outliers = draw.index(3);
    for (int k = 0; k < outliers; ++k) add_outlier(s.problem, k, draw.uniform(15, 30), draw);

    const int most = (n - 1) / 2;
    const BruteForce expected = brute_force(s, most);
    const PoseEstimate estimate = solve("orpe_tree", s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    EXPECT_EQ(is_test_failed(estimate), expected.removals < 0) << i;
    if (expected.removals < 0) continue;
    EXPECT_EQ(static_cast<int>(estimate.removed.size()), expected.removals) << i;
    const Correspondences c = prepare(s.problem).correspondences;
    const double actual_px2 =
        minimax_px2(c, complement(estimate.removed, n), to_centred(s.cam_from_target, c));
    EXPECT_LE(actual_px2, expected.minimax_px2 * (1 + 10 * kMinimaxGap)) << i;
  }
}

TEST(OrpeTree, LosesAGoodPointAsOftenAsStated) {
  constexpr int kTrials = 2000;
  for (const double rate : {0.1, 0.02}) {
    SolverOptions options;
    options.outliers.false_alarm_rate = rate;
    Draw draw(2);
    int removed = 0;
    for (int i = 0; i < kTrials; ++i) {
      Synthetic s = cube_problem(1, draw);
      s.problem.sigma_px = 1;
      removed += !solve("orpe_tree", s.problem, options).removed.empty();
    }
    const double sd = std::sqrt(rate / kTrials);
    // A cube's quantiles are a tenth below those of points in a box.
    EXPECT_NEAR(removed / double(kTrials), rate, 4 * sd + 0.4 * rate);
  }
}

TEST(OrpeTree, FindsUpToThreeOfEight) {
  constexpr int kTrials = 100;
  Draw draw(3);
  for (int outliers = 1; outliers <= 3; ++outliers) {
    int found = 0;
    for (int i = 0; i < kTrials; ++i) {
      Synthetic s = cube_problem(0.5, draw);
      s.problem.sigma_px = 0.5;
      for (int k = 0; k < outliers; ++k) add_outlier(s.problem, 2 * k, draw.uniform(15, 30), draw);
      const PoseEstimate estimate = solve("orpe_tree", s.problem);
      const PoseEstimate oracle = find_pose_solver("oracle")->solve(s.problem, {});
      if (estimate.removed != oracle.removed) continue;
      ++found;
      EXPECT_TRUE(is_pose_near(estimate.cam_from_target, oracle.cam_from_target, 1e-7, 1e-4));
      EXPECT_FALSE(is_test_failed(estimate));
      EXPECT_FALSE(is_removal_limit_reached(estimate));
    }
    EXPECT_GE(found, 0.97 * kTrials) << outliers;
  }
}

TEST(OrpeTree, SaysWhenNoSetItMayTryPasses) {
  Draw draw(4);
  SolverOptions one;
  one.outliers.max_removed = 1;
  for (int i = 0; i < 20; ++i) {
    Synthetic s = cube_problem(0.3, draw);
    s.problem.sigma_px = 0.3;
    add_outlier(s.problem, 0, 30, draw);
    EXPECT_FALSE(is_test_failed(solve("orpe_tree", s.problem, one)));
    add_outlier(s.problem, 7, 30, draw);
    const PoseEstimate estimate = solve("orpe_tree", s.problem, one);
    EXPECT_TRUE(is_test_failed(estimate));
    EXPECT_TRUE(is_removal_limit_reached(estimate));
    EXPECT_LE(estimate.removed.size(), 1u);
    EXPECT_EQ(estimate.status, PoseStatus::kOk);
  }
}

TEST(OrpeTree, EstimatesNoiseThatIsNotKnown) {
  constexpr int kTrials = 100;
  Draw draw(5);
  for (const double sigma_px : {1e-3, 0.5}) {
    int found = 0;
    int kept_all = 0;
    for (int i = 0; i < kTrials; ++i) {
      Synthetic s = cube_problem(sigma_px, draw);
      kept_all += solve("orpe_tree", s.problem).removed.empty();
      add_outlier(s.problem, 3, draw.uniform(15, 30), draw);
      found += solve("orpe_tree", s.problem).removed == std::vector<int>{3};
    }
    EXPECT_GE(found, 0.95 * kTrials) << sigma_px;
    EXPECT_GE(kept_all, 0.95 * kTrials) << sigma_px;
  }
}

TEST(OrpeTree, AWideCovarianceExcusesAPoint) {
  Draw draw(6);
  for (int i = 0; i < 50; ++i) {
    Synthetic s = cube_problem(0.5, draw);
    s.problem.sigma_px = 100;  // not looked at where there are covariances
    s.problem.covariances_px2.assign(8, 0.25 * Eigen::Matrix2d::Identity());
    add_outlier(s.problem, 4, 30, draw);
    EXPECT_THAT(solve("orpe_tree", s.problem).removed, ElementsAre(4));

    s.problem.covariances_px2[4] = 900 * Eigen::Matrix2d::Identity();
    const PoseEstimate excused = solve("orpe_tree", s.problem);
    ASSERT_EQ(excused.status, PoseStatus::kOk);
    EXPECT_THAT(excused.removed, IsEmpty());
    // It has next to no weight.
    const PoseEstimate oracle = find_pose_solver("oracle")->solve(s.problem, {});
    EXPECT_LT(geodesic_angle_rad(excused.cam_from_target.rotation, oracle.cam_from_target.rotation),
              1e-3);
  }
}

TEST(OrpeTree, CovariancesThatAreNoneSaySo) {
  Draw draw(7);
  PoseProblem problem = cube_problem(1, draw).problem;
  problem.covariances_px2.assign(8, Eigen::Matrix2d::Identity());
  EXPECT_EQ(solve("orpe_tree", problem).status, PoseStatus::kOk);

  problem.covariances_px2.pop_back();
  EXPECT_EQ(solve("orpe_tree", problem).status, PoseStatus::kTooFewPoints);
  for (const double bad : {0.0, -1.0, kNaN, kInfinity}) {
    problem.covariances_px2.assign(8, Eigen::Matrix2d::Identity());
    problem.covariances_px2[5](1, 1) = bad;
    EXPECT_EQ(find_pose_solver("orpe_tree")->core(problem, {}).status, PoseStatus::kDegenerate);
    const PoseEstimate estimate = solve("orpe_tree", problem);
    EXPECT_EQ(estimate.ignored, std::vector{5}) << bad;
    EXPECT_TRUE(is_free_of_nan(estimate));
  }
  problem.covariances_px2.clear();
  problem.sigma_px = -1;
  EXPECT_EQ(solve("orpe_tree", problem).status, PoseStatus::kDegenerate);
}

// Five points near a plane, as an aircraft's, have two mirror poses; an outlier may favour the
// wrong one.
TEST(OrpeTree, BothMirrorStartsHaveATree) {
  constexpr int kTrials = 100;
  Draw draw(8);
  const std::vector<Eigen::Vector3d> points = {{-20, 1, 0},  {20, 1, 0.5}, {-18, -3, 0.5},
                                               {18, -3, 0},  {0, 20, 1},   {0, -22, 0.5},
                                               {8, 4, -0.5}, {-8, 4, -0.5}};
  int right = 0;
  for (int i = 0; i < kTrials; ++i) {
    Synthetic s =
        exact_problem(centred_camera(512, 512, 10000), points,
                      {rotation_from_vector({0.7, 0.4, draw.uniform(-3, 3)}), {0, 0, 400}});
    add_noise(s.problem, 0.05, draw);
    s.problem.sigma_px = 0.05;
    add_outlier(s.problem, draw.index(8), draw.uniform(15, 30), draw);
    const PoseEstimate estimate = solve("orpe_tree", s.problem);
    right +=
        estimate.status == PoseStatus::kOk &&
        geodesic_angle_rad(estimate.cam_from_target.rotation, s.cam_from_target.rotation) < 0.02;
  }
  EXPECT_GE(right, 0.97 * kTrials);
}

}  // namespace
}  // namespace sightline
