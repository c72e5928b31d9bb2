// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/camera.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

constexpr double kPixelRounding = 1e-10;  // 512 px times a few hundred epsilon

Camera wide_camera_with_lens() {
  Camera camera = centred_camera(640, 480, 500);
  camera.fy_px = 510;
  camera.lens = BrownConrady{.k1 = -0.28, .k2 = 0.09, .p1 = 1e-3, .p2 = -5e-4, .k3 = -0.01};
  return camera;
}

TEST(Camera, CentredPrincipalPointIsBetweenTheMiddlePixels) {
  const Camera camera = centred_camera(512, 400, 1000);
  EXPECT_EQ(camera.cx_px, 255.5);
  EXPECT_EQ(camera.cy_px, 199.5);
  EXPECT_EQ(camera.fx_px, camera.fy_px);
  EXPECT_TRUE(is_pinhole(camera.lens));
  // Three pixels: the middle one has its centre at 1.
  EXPECT_EQ(centred_camera(3, 3, 1).cx_px, 1);
}

TEST(Camera, ProjectsRightToRightAndDownToDown) {
  const Camera camera = centred_camera(512, 512, 1000);
  const auto centre = project(camera, {0, 0, 10});
  ASSERT_TRUE(centre);
  EXPECT_TRUE(is_matrix_near(*centre, Eigen::Vector2d(255.5, 255.5), 0));
  EXPECT_TRUE(is_matrix_near(*project(camera, {1, 0, 10}), Eigen::Vector2d(355.5, 255.5), 1e-13));
  EXPECT_TRUE(is_matrix_near(*project(camera, {0, 1, 10}), Eigen::Vector2d(255.5, 355.5), 1e-13));
}

TEST(Camera, SeesNothingBehindOrBeside) {
  const Camera camera = centred_camera(512, 512, 1000);
  EXPECT_TRUE(project(camera, {0, 0, 1e-9}));
  EXPECT_FALSE(project(camera, {0, 0, 0}));
  EXPECT_FALSE(project(camera, {0, 0, -1}));
  EXPECT_FALSE(project(camera, {0, 0, kNaN}));
}

TEST(Camera, LensFollowsOpenCv) {
  // Worked by hand for x = 0.5, y = -0.25: r2 = 0.3125.
  const BrownConrady lens = {.k1 = 0.1, .k2 = 0.2, .p1 = 0.01, .p2 = 0.02, .k3 = 0.3};
  const double r2 = 0.3125;
  const double radial = 1 + 0.1 * r2 + 0.2 * r2 * r2 + 0.3 * r2 * r2 * r2;
  const Eigen::Vector2d expected(0.5 * radial + 2 * 0.01 * -0.125 + 0.02 * (r2 + 0.5),
                                 -0.25 * radial + 0.01 * (r2 + 0.125) + 2 * 0.02 * -0.125);
  EXPECT_TRUE(is_matrix_near(distorted(lens, {0.5, -0.25}), expected, kEpsilon));
}

TEST(Camera, LensDerivativeIsThatOfDifferences) {
  const Lens lens = wide_camera_with_lens().lens;
  constexpr double kStep = 1e-6;
  Draw draw(1);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d x = 0.5 * draw.in_box(1).head<2>();
    Eigen::Matrix2d numeric;
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector2d h = kStep * Eigen::Vector2d::Unit(k);
      numeric.col(k) = (distorted(lens, x + h) - distorted(lens, x - h)) / (2 * kStep);
    }
    EXPECT_TRUE(is_matrix_near(distortion_jacobian(lens, x), numeric, 1e-9));
  }
}

TEST(Camera, UndistortionUndoesDistortion) {
  for (const Camera& camera : {centred_camera(512, 512, 15000), wide_camera_with_lens()}) {
    Draw draw(2);
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector2d pixel(draw.uniform(-0.5, camera.width_px - 0.5),
                                  draw.uniform(-0.5, camera.height_px - 0.5));
      const auto normalised = normalised_from_pixel(camera, pixel);
      ASSERT_TRUE(normalised) << pixel.transpose();
      const Eigen::Vector3d x_in_cam = 7 * Eigen::Vector3d(normalised->x(), normalised->y(), 1);
      EXPECT_TRUE(is_matrix_near(project(camera, x_in_cam).value(), pixel, kPixelRounding));

      const auto direction = bearing(camera, pixel);
      ASSERT_TRUE(direction);
      EXPECT_NEAR(direction->norm(), 1, 4 * kEpsilon);
      EXPECT_LE(direction->cross(x_in_cam).norm(), 1e-14);
      EXPECT_GT(direction->z(), 0);
    }
  }
}

TEST(Camera, DistortionIsNotIgnored) {
  Camera plain = wide_camera_with_lens();
  plain.lens = {};
  const Eigen::Vector3d corner(0.6, 0.4, 1);
  EXPECT_GT((*project(plain, corner) - *project(wide_camera_with_lens(), corner)).norm(), 20);
}

TEST(Camera, BeyondTheFoldOfTheLensIsNothing) {
  Camera barrel = centred_camera(640, 480, 300);
  std::get<BrownConrady>(barrel.lens).k1 = -0.3;  // x (1 - 0.3 x^2) never exceeds 0.703
  EXPECT_TRUE(normalised_from_pixel(barrel, {barrel.cx_px + 300 * 0.69, barrel.cy_px}));
  EXPECT_FALSE(normalised_from_pixel(barrel, {barrel.cx_px + 300 * 0.71, barrel.cy_px}));
  EXPECT_FALSE(bearing(barrel, {barrel.cx_px + 300 * 0.71, barrel.cy_px}));
}

TEST(Camera, PixelsThatAreNotFiniteHaveNoRay) {
  for (const Camera& camera : {centred_camera(512, 512, 15000), wide_camera_with_lens()}) {
    EXPECT_FALSE(normalised_from_pixel(camera, {kNaN, 0}));
    EXPECT_FALSE(bearing(camera, {0, kInfinity}));
  }
}

TEST(Camera, ImageReachesHalfAPixelBeyondTheCentres) {
  const Camera camera = centred_camera(4, 3, 1);
  EXPECT_TRUE(is_inside(camera, {-0.5, -0.5}));
  EXPECT_TRUE(is_inside(camera, {3.5, 2.5}));
  EXPECT_FALSE(is_inside(camera, {-0.51, 0}));
  EXPECT_FALSE(is_inside(camera, {3.51, 0}));
  EXPECT_FALSE(is_inside(camera, {0, 2.51}));
  EXPECT_FALSE(is_inside(camera, {kNaN, 0}));
  EXPECT_TRUE(is_inside(camera, {0.5, 0.5}, 1));
  EXPECT_FALSE(is_inside(camera, {0.49, 0.5}, 1));
  EXPECT_FALSE(is_inside(camera, {0.5, 1.51}, 1));
}

}  // namespace
}  // namespace sightline
