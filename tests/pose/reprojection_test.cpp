// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/reprojection.h"

#include <gtest/gtest.h>

#include "tests/pose/matchers.h"
#include "tests/pose/solvers/solving.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

TEST(Reprojection, JacobianIsThatOfDifferences) {
  constexpr double kStep = 1e-6;
  Draw draw(16);
  for (int i = 0; i < 50; ++i) {
    Camera camera = centred_camera(512, 512, 1000);
    camera.fy_px = 1300;
    Synthetic s =
        exact_problem(camera, points_in_box(6, {1, 1, 1}, draw), {draw.rotation(), {0.5, -0.3, 6}});
    add_noise(s.problem, 5, draw);
    const PreparedProblem prepared = prepare(s.problem);
    ASSERT_EQ(prepared.status, PoseStatus::kOk);
    const Correspondences& c = prepared.correspondences;
    const Pose pose = to_centred(s.cam_from_target, c);
    for (std::size_t k = 0; k < c.size(); ++k) {
      Eigen::Matrix<double, 2, 6> numeric;
      for (int column = 0; column < 6; ++column) {
        const Vector6d h = kStep * Vector6d::Unit(column);
        numeric.col(column) =
            (*residual_px(c, k, retract(pose, h)) - *residual_px(c, k, retract(pose, -h))) /
            (2 * kStep);
      }
      const auto analytic = reproject(c, k, pose);
      ASSERT_TRUE(analytic);
      // Entries reach 1300 px/rad; the differences err by kStep^2 of the third derivative.
      EXPECT_TRUE(is_matrix_near(analytic->jacobian, numeric, 1e-5));
      EXPECT_TRUE(is_matrix_near(analytic->residual_px, *residual_px(c, k, pose), 1e-10));
      EXPECT_TRUE(is_matrix_near(
          analytic->residual_px,
          project(camera, s.cam_from_target * s.problem.points_in_target[k]).value() -
              s.problem.pixels[k],
          1e-10));
    }
  }
}

TEST(Reprojection, PointBehindTheCameraHasNone) {
  Draw draw(17);
  const Synthetic s = cube_problem(0, draw);
  const Correspondences c = prepare(s.problem).correspondences;
  Pose behind = to_centred(s.cam_from_target, c);
  EXPECT_TRUE(reproject(c, 0, behind));
  EXPECT_TRUE(residual_px(c, 0, behind));
  behind.translation.z() *= -1;
  EXPECT_FALSE(reproject(c, 0, behind));
  EXPECT_FALSE(residual_px(c, 0, behind));
}

TEST(Reprojection, CentringIsUndone) {
  Draw draw(18);
  Synthetic s = cube_problem(0, draw);
  for (auto& x : s.problem.points_in_target) x += Eigen::Vector3d(3, -2, 1);
  const Correspondences c = prepare(s.problem).correspondences;
  EXPECT_TRUE(is_matrix_near(c.centroid_in_target, Eigen::Vector3d(3, -2, 1), 1e-14));
  EXPECT_TRUE(is_pose_near(from_centred(to_centred(s.cam_from_target, c), c), s.cam_from_target,
                           kRotationRounding, 1e-12));
}

}  // namespace
}  // namespace sightline
