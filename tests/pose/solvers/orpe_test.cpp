// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pose/minimise.h"
#include "pose/reprojection.h"
#include "pose/solver.h"
#include "tests/pose/matchers.h"
#include "tests/pose/solvers/solving.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Orpe, RemovesASingleOutlier) {
  constexpr int kTrials = 300;
  Draw draw(25);
  int exact_sets = 0;
  double orpe2 = 0, lspe2 = 0;
  for (int i = 0; i < kTrials; ++i) {
    Synthetic s = cube_problem(0.3, draw);
    const int outlier = draw.index(8);
    add_outlier(s.problem, outlier, 30, draw);
    const PoseEstimate estimate = solve("orpe", s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    exact_sets += estimate.removed == std::vector<int>{outlier};
    const auto error = [&s](const PoseEstimate& e) {
      return geodesic_angle_rad(e.cam_from_target.rotation, s.cam_from_target.rotation);
    };
    orpe2 += std::pow(error(estimate), 2);
    lspe2 += std::pow(error(solve("lspe", s.problem)), 2);
  }
  EXPECT_GE(exact_sets, 0.98 * kTrials);
  EXPECT_LT(std::sqrt(orpe2), 0.1 * std::sqrt(lspe2));
}

TEST(Orpe, KeepsAllWhenThereIsNoOutlier) {
  constexpr int kTrials = 300;
  Draw draw(26);
  int kept_all = 0;
  for (int i = 0; i < kTrials; ++i) {
    const PoseEstimate estimate = solve("orpe", cube_problem(1, draw).problem);
    kept_all += estimate.status == PoseStatus::kOk && estimate.removed.empty();
  }
  EXPECT_GE(kept_all, 0.98 * kTrials);
}

TEST(Orpe, RhoIsTheThreshold) {
  Draw draw(27);
  Synthetic s = cube_problem(0.3, draw);
  add_outlier(s.problem, 5, 30, draw);
  SolverOptions options;
  options.orpe.rho = 10;
  EXPECT_THAT(solve("orpe", s.problem, options).removed, ElementsAre(5));
  options.orpe.rho = 1e9;
  EXPECT_THAT(solve("orpe", s.problem, options).removed, IsEmpty());
}

TEST(Orpe, RhoThatIsNoRatioRemovesNothingFromExactPoints) {
  Draw draw(39);
  for (const double rho : {kNaN, 0.0, -1.0, 1.0}) {
    SolverOptions options;
    options.orpe.rho = rho;
    EXPECT_THAT(solve("orpe", cube_problem(0, draw).problem, options).removed, IsEmpty()) << rho;
  }
}

TEST(Orpe, NeverLeavesFewerThanFourPoints) {
  Draw draw(28);
  SolverOptions eager;
  eager.orpe.rho = 1 + 1e-9;
  for (std::size_t n = 4; n <= 8; ++n) {
    std::size_t most_removed = 0;
    for (int i = 0; i < 30; ++i) {
      const PoseProblem problem = first_points(cube_problem(10, draw).problem, n);
      const PoseEstimate estimate = solve("orpe", problem, eager);
      EXPECT_LE(estimate.removed.size(), n - 4);
      EXPECT_TRUE(std::ranges::is_sorted(estimate.removed));
      most_removed = std::max(most_removed, estimate.removed.size());
    }
    EXPECT_EQ(most_removed, n - 4);
  }
}

TEST(Orpe, FindsTheOutlierAmongExactPoints) {
  Draw draw(29);
  for (int i = 0; i < 50; ++i) {
    Synthetic s = cube_problem(0, draw);
    add_outlier(s.problem, 2, 30, draw);
    const PoseEstimate estimate = solve("orpe", s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    EXPECT_THAT(estimate.removed, ElementsAre(2));
    EXPECT_TRUE(is_pose_near(estimate.cam_from_target, s.cam_from_target, 1e-8, 1e-5));
  }
}

TEST(Orpe, RoundingIsNoOutlier) {
  // All residuals below the floor: Lambda is 1, whatever their ratio.
  Draw draw(30);
  SolverOptions eager;
  eager.orpe.rho = 1.001;
  for (int i = 0; i < 50; ++i) {
    Synthetic s = cube_problem(0, draw);
    s.problem.pixels[1] += Eigen::Vector2d(5e-7, 0);
    const PoseEstimate estimate = solve("orpe", s.problem, eager);
    EXPECT_EQ(estimate.status, PoseStatus::kOk);
    EXPECT_THAT(estimate.removed, IsEmpty());
  }
}

// Documented in orpe.cpp: max f is at most ln(n) / 512 of itself above the exact minimax. For any
// weights that sum to one, min max_i f_i >= min sum w_i f_i: the right side, by Gauss-Newton on
// weighted residuals, is a certificate.
TEST(Orpe, MinimaxMeetsItsCertificate) {
  Draw draw(31);
  SolverOptions keep_all;
  keep_all.orpe.rho = kInfinity;
  for (int i = 0; i < 50; ++i) {
    Synthetic s = cube_problem(1, draw);
    if (i % 2) add_outlier(s.problem, 0, 20, draw);
    const PoseEstimate estimate = solve("orpe", s.problem, keep_all);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    const double largest = largest_squared_error_px2(s.problem, estimate.cam_from_target);

    const Correspondences c = prepare(s.problem).correspondences;
    Eigen::VectorXd weights(8);
    for (int k = 0; k < 8; ++k) {
      const double f = squared_error_px2(s.problem, k, estimate.cam_from_target);
      weights[k] = std::exp(512 / largest * (f - largest));
    }
    weights /= weights.sum();
    const auto weighted_model = [&](const Pose& pose) -> std::optional<LocalModel> {
      LocalModel model;
      for (int k = 0; k < 8; ++k) {
        const auto r = reproject(c, k, pose);
        if (!r) return std::nullopt;
        model.cost += weights[k] * r->residual_px.squaredNorm();
        model.gradient += 2 * weights[k] * r->jacobian.transpose() * r->residual_px;
        model.hessian += 2 * weights[k] * r->jacobian.transpose() * r->jacobian;
      }
      return model;
    };
    const Minimum bound =
        minimise(to_centred(estimate.cam_from_target, c), weighted_model, 500, 1e-8);
    EXPECT_GE(largest, bound.model.cost * (1 - 1e-9));
    EXPECT_LE(largest, bound.model.cost * (1 + 1.1 * std::log(8.0) / 512));
    // Least squares has the smaller sum and the larger maximum.
    EXPECT_LT(largest,
              largest_squared_error_px2(s.problem, solve("lspe", s.problem).cam_from_target));
  }
}

TEST(Orpe, NoPerturbationLowersTheLargestError) {
  Draw draw(32);
  SolverOptions keep_all;
  keep_all.orpe.rho = kInfinity;
  for (int i = 0; i < 20; ++i) {
    const Synthetic s = cube_problem(1, draw);
    const Pose pose = solve("orpe", s.problem, keep_all).cam_from_target;
    const double largest = largest_squared_error_px2(s.problem, pose);
    for (int k = 0; k < 500; ++k) {
      const double size = std::pow(10, draw.uniform(-6, 0));
      Vector6d delta;
      delta << size * draw.vector(), size * 0.1 * pose.translation.norm() * draw.vector();
      EXPECT_GE(largest_squared_error_px2(s.problem, retract(pose, delta)),
                largest * (1 - std::log(8.0) / 512));
    }
  }
}

TEST(Orpe, KeepsAPointWithoutWhichTheOthersAreCollinear) {
  Draw draw(33);
  Synthetic s = exact_problem(centred_camera(512, 512, 5000),
                              {{-1, 0, 0}, {-0.3, 0, 0}, {0.4, 0, 0}, {1, 0, 0}, {0, 1, 0.2}},
                              {draw.rotation_by(0.5), {0, 0, 50}});
  add_outlier(s.problem, 4, 30, draw);
  const PoseEstimate estimate = solve("orpe", s.problem);
  EXPECT_TRUE(is_free_of_nan(estimate));
  EXPECT_FALSE(std::ranges::count(estimate.removed, 4));
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
