// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/robust.h"

#include <algorithm>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "pose/starts.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

Camera wide_camera() {
  Camera camera = centred_camera(640, 480, 500);
  camera.fy_px = 530;
  camera.lens = BrownConrady{.k1 = -0.2, .k2 = 0.05, .p1 = 1e-3, .p2 = -1e-3, .k3 = 0};
  return camera;
}

TEST(Robust, ThresholdIsExceededAtTheStatedRate) {
  constexpr int kDraws = 20000;
  Draw draw(1);
  for (const std::size_t n : {4u, 8u, 20u}) {
    const double t2 = squared_threshold(0.1, n);
    int alarms = 0;
    for (int i = 0; i < kDraws; ++i) {
      double largest = 0;
      for (std::size_t k = 0; k < n; ++k) {
        largest = std::max(largest, draw.pixel_noise(1).squaredNorm());
      }
      alarms += largest > t2;
    }
    // Three standard deviations of a binomial count.
    EXPECT_NEAR(alarms, 0.1 * kDraws, 3 * std::sqrt(0.09 * kDraws)) << n;
  }
}

TEST(Robust, ThresholdIsFiniteWhateverTheRate) {
  for (const double rate : {-1.0, 0.0, 1.0, 2.0, kNaN, kInfinity}) {
    EXPECT_TRUE(std::isfinite(squared_threshold(rate, 8))) << rate;
    EXPECT_GT(squared_threshold(rate, 8), 1) << rate;
  }
}

TEST(Robust, MedianGivesSigma) {
  Draw draw(2);
  std::vector<double> squares;
  for (int i = 0; i < 20000; ++i) squares.push_back(draw.pixel_noise(0.7).squaredNorm());
  EXPECT_NEAR(sigma_from_median(squares), 0.7, 0.02);
  // Not much of it changes when a third of the points is wild or behind the camera.
  for (int i = 0; i < 6666; ++i) squares[i] = kInfinity;
  EXPECT_LT(sigma_from_median(squares), 1.2);
  for (double& r2 : squares) r2 = kInfinity;
  EXPECT_EQ(sigma_from_median(squares), kSmallestSigma);
  EXPECT_EQ(sigma_from_median(std::vector<double>(8, 0.0)), kSmallestSigma);
}

TEST(Robust, HuberLossIsTheIntegralOfItsWeight) {
  constexpr double kStep = 1e-5;
  const HuberLoss loss{1.5};
  for (double r = 0.05; r < 5; r += 0.1) {
    const auto cost = [&loss](double x) { return loss(x * x).cost; };
    const auto force = [&loss](double x) { return x * loss(x * x).weight; };
    EXPECT_NEAR((cost(r + kStep) - cost(r - kStep)) / (2 * kStep), force(r), 1e-9);
    EXPECT_NEAR((force(r + kStep) - force(r - kStep)) / (2 * kStep), loss(r * r).curvature, 1e-9);
  }
}

// Pixels drawn with their covariances, through the lens: the mean square of two whitened
// coordinates is two.
TEST(Robust, WhitenedResidualsHaveUnitVariance) {
  constexpr int kDraws = 3000;
  Draw draw(3);
  Eigen::Matrix2d covariance;
  covariance << 0.5, 0.2, 0.2, 0.1;
  const Eigen::Matrix2d root = covariance.llt().matrixL();
  const Pose cam_from_target = {draw.rotation(), {0.8, -0.5, 2.5}};
  const Synthetic exact = exact_problem(wide_camera(), cube_vertices(), cam_from_target);
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    PoseProblem noisy = exact.problem;
    noisy.covariances_px2.assign(8, covariance);
    noisy.sigma_px = 7;  // covariances go first
    for (auto& u : noisy.pixels) u += root * draw.pixel_noise(1);
    const PreparedWhitened prepared = prepare_whitened(noisy);
    ASSERT_EQ(prepared.status, PoseStatus::kOk);
    const WhitenedCorrespondences& c = prepared.correspondences;
    EXPECT_EQ(c.sigma, 1);
    const Pose pose = to_centred(cam_from_target, c.points);
    for (std::size_t k = 0; k < 8; ++k) {
      const Eigen::Vector2d r = *whitened_residual(c, k, pose);
      sum += r * r.transpose() / (8 * kDraws);
      EXPECT_TRUE(is_matrix_near(whitened_reprojection(c, k, pose)->residual_px, r, 1e-9));
    }
  }
  EXPECT_TRUE(is_matrix_near(sum, Eigen::Matrix2d::Identity(), 0.03));
}

TEST(Robust, WhitenedLeastSquaresWithEqualCovariancesIsLeastSquares) {
  Draw draw(4);
  Synthetic s = cube_problem(1, draw);
  const PreparedWhitened plain = prepare_whitened(s.problem);
  s.problem.covariances_px2.assign(8, 4 * Eigen::Matrix2d::Identity());
  const PreparedWhitened whitened = prepare_whitened(s.problem);
  ASSERT_EQ(whitened.status, PoseStatus::kOk);
  std::vector<double> weights(8, 1.0);
  weights[3] = 0;
  const auto solve = [&](const PreparedWhitened& p) {
    const WhitenedCorrespondences& c = p.correspondences;
    return whitened_least_squares(c, starting_poses(c.points, {}), {}, weights);
  };
  const LeastSquares a = solve(plain);
  const LeastSquares b = solve(whitened);
  ASSERT_EQ(a.status, PoseStatus::kOk);
  ASSERT_EQ(b.status, PoseStatus::kOk);
  EXPECT_TRUE(is_pose_near(a.cam_from_centred, b.cam_from_centred, 1e-9, 1e-7));
  EXPECT_NEAR(a.cost_px2, 4 * b.cost_px2, 1e-6);
  EXPECT_TRUE(
      is_matrix_near(4 * a.unit_covariance, b.unit_covariance, 1e-6 * b.unit_covariance.norm()));
}

TEST(Robust, WrongCovariancesSaySo) {
  Draw draw(5);
  PoseProblem problem = cube_problem(1, draw).problem;
  const Eigen::Matrix2d good = Eigen::Matrix2d::Identity();
  problem.covariances_px2.assign(8, good);
  EXPECT_EQ(prepare_whitened(problem).status, PoseStatus::kOk);
  problem.covariances_px2.resize(7);
  EXPECT_EQ(prepare_whitened(problem).status, PoseStatus::kTooFewPoints);
  Eigen::Matrix2d indefinite, asymmetric;
  indefinite << 1, 2, 2, 1;
  asymmetric << 1, 0.5, 0, 1;
  for (const Eigen::Matrix2d& bad :
       {Eigen::Matrix2d(Eigen::Matrix2d::Zero()), Eigen::Matrix2d(-good),
        Eigen::Matrix2d(kNaN * good), Eigen::Matrix2d(kInfinity * good), indefinite, asymmetric}) {
    problem.covariances_px2.assign(8, good);
    problem.covariances_px2[5] = bad;
    EXPECT_EQ(prepare_whitened(problem).status, PoseStatus::kDegenerate) << bad;
  }
  problem.covariances_px2.clear();
  for (const double bad : {-1.0, kNaN, kInfinity}) {
    problem.sigma_px = bad;
    EXPECT_EQ(prepare_whitened(problem).status, PoseStatus::kDegenerate) << bad;
  }
}

TEST(Robust, CanonicalOrderFollowsThePoints) {
  Draw draw(6);
  const Correspondences c = prepare(cube_problem(1, draw).problem).correspondences;
  Correspondences reversed = c;
  std::ranges::reverse(reversed.points_in_centred);
  std::ranges::reverse(reversed.pixels);
  const std::vector<std::size_t> a = canonical_order(c);
  const std::vector<std::size_t> b = canonical_order(reversed);
  for (std::size_t k = 0; k < 8; ++k) EXPECT_EQ(a[k], 7 - b[k]);
  EXPECT_FALSE(std::ranges::is_sorted(a)) << "a mixed order was expected";
}

}  // namespace
}  // namespace sightline
