// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/fit_points.h"

#include <vector>

#include <gtest/gtest.h>

#include "pose/reprojection.h"
#include "pose/starts.h"
#include "tests/pose/matchers.h"
#include "tests/pose/solvers/solving.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

TEST(FitPoints, WhiteningMultipliesResidualAndJacobian) {
  Draw draw(12);
  const Correspondences c = noisy_cube(0, 1, draw);
  std::vector<Eigen::Matrix2d> whitening(8, Eigen::Matrix2d::Identity());
  whitening[3] << 2, 0.5, 0, 3;
  const std::vector<int> kept = {1, 3};
  const FitPoints points = {c, kept, whitening};
  const Pose pose = starting_poses(c, std::nullopt).front();
  const auto plain = reproject(c, 3, pose);
  const auto whitened = reproject(points, 1, pose);
  ASSERT_TRUE(plain && whitened);
  EXPECT_EQ(points.size(), 2u);
  EXPECT_TRUE(is_matrix_near(whitened->residual_px, whitening[3] * plain->residual_px, 1e-12));
  EXPECT_TRUE(is_matrix_near(whitened->jacobian, whitening[3] * plain->jacobian, 1e-9));
}

TEST(FitPoints, LeastSquaresWeighsByTheWhiteningAsItIs) {
  // Not symmetric: its square in the cost is the transposed times itself, not itself twice.
  Draw draw(15);
  const Correspondences c = noisy_cube(0, 1, draw);
  std::vector<Eigen::Matrix2d> whitening(8);
  for (int i = 0; i < 8; ++i) whitening[i] << 2, 1.5 - 0.3 * i, 0, 1;
  const FitPoints points = {c, {}, whitening};
  const LeastSquares fit = least_squares(points, starting_poses(c, std::nullopt), {});
  ASSERT_EQ(fit.status, PoseStatus::kOk);
  double cost_px2 = 0;
  Vector6d gradient = Vector6d::Zero();
  double scale = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto r = reproject(points, i, fit.cam_from_centred);
    ASSERT_TRUE(r);
    cost_px2 += r->residual_px.squaredNorm();
    gradient += r->jacobian.transpose() * r->residual_px;
    scale += r->jacobian.norm() * r->residual_px.norm();
  }
  EXPECT_NEAR(fit.cost_px2, cost_px2, 1e-9 * cost_px2);
  EXPECT_LT(gradient.norm(), 1e-6 * scale);
}

TEST(FitPoints, LeastSquaresLeavesOutWhatIsNotKept) {
  Draw draw(14);
  Synthetic s = cube_problem(1, draw);
  add_outlier(s.problem, 5, 30, draw);
  const Correspondences c = prepare(s.problem).correspondences;
  const std::vector<Pose> starts = starting_poses(c, std::nullopt);
  const std::vector<int> kept = {0, 1, 2, 3, 4, 6, 7};
  const std::vector<Eigen::Matrix2d> ones(8, Eigen::Matrix2d::Identity());
  const LeastSquares expected = least_squares(without(c, 5), starts, {});
  for (const LeastSquares& actual :
       {least_squares({c, kept, {}}, starts, {}), least_squares({c, kept, ones}, starts, {})}) {
    ASSERT_EQ(actual.status, PoseStatus::kOk);
    EXPECT_TRUE(is_pose_near(actual.cam_from_centred, expected.cam_from_centred, 1e-8, 1e-6));
    EXPECT_NEAR(actual.cost_px2, expected.cost_px2, 1e-9 * expected.cost_px2);
    EXPECT_TRUE(is_matrix_near(actual.unit_covariance, expected.unit_covariance,
                               1e-6 * expected.unit_covariance.norm()));
  }
}

}  // namespace
}  // namespace sightline
