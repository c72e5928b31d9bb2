// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What single methods of the catalogue promise beyond what holds for all.
#include <cmath>

#include <gtest/gtest.h>

#include "pose/absolute_orientation.h"
#include "tests/pose/matchers.h"
#include "tests/pose/orientation/clouds.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

TEST(UmeyamaScaled, FindsTheScale) {
  Draw draw(39);
  const OrientationMethod* method = find_orientation_method("umeyama_scaled");
  for (const double scale : {1e-3, 0.5, 1.0, 7.0, 1e4}) {
    const Pose b_from_a = {draw.rotation(), {1, 2, 3}};
    Cloud cloud = draw_cloud(10, {10, 8, 9}, 5, {b_from_a.rotation, {0, 0, 0}}, draw);
    for (Eigen::Vector3d& x : cloud.in_b) x = scale * x + b_from_a.translation;
    const OrientationEstimate estimate = method->estimate(cloud.in_a, cloud.in_b);
    ASSERT_EQ(estimate.status, OrientationStatus::kOk);
    EXPECT_NEAR(estimate.scale / scale, 1, 1e-13);
    EXPECT_TRUE(is_pose_near(estimate.b_from_a, b_from_a, 1e-12, 1e-12 * (1 + 20 * scale)));
  }
}

TEST(GaussNewton, ConvergesFromSaddlesAndFromTheMinimum) {
  Draw draw(40);
  const OrientationMethod* method = find_orientation_method("gauss_newton");
  const Points box = {{3, 2, 1}, {3, -2, -1}, {-3, 2, -1}, {-3, -2, 1}};  // principal axes x, y, z
  for (int i = 0; i < 200; ++i) {
    // Exactly half a turn about a principal axis, where the gradient at the identity vanishes; or
    // nearly, about any axis.
    const Eigen::Matrix3d rotation =
        i < 3
            ? Eigen::Matrix3d(2 * Eigen::Vector3d::Unit(i) * Eigen::Vector3d::Unit(i).transpose() -
                              Eigen::Matrix3d::Identity())
            : draw.rotation_by(kPi - (i % 4 ? std::pow(10.0, -(i % 16)) : 0.0));
    const Pose b_from_a = {rotation, draw.in_box(10)};
    Points in_b;
    for (const Eigen::Vector3d& x : box) in_b.push_back(b_from_a * x);
    const OrientationEstimate estimate = method->estimate(box, in_b);
    ASSERT_EQ(estimate.status, OrientationStatus::kOk) << i;
    EXPECT_TRUE(is_pose_near(estimate.b_from_a, b_from_a, 1e-12, 1e-12)) << i;
  }
}

}  // namespace
}  // namespace sightline
