// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Each lens is drawn truly: the corners of a plate, measured in the image, lie where the camera
// projects them.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "renderer/renderer.h"
#include "tests/pose/lenses/lenses_for_tests.h"
#include "tests/renderer/scenes_for_tests.h"

namespace sightline {
namespace {

constexpr double kPromisePx = 0.02;

const std::array<Eigen::Vector3d, 4> kCorners = {
    Eigen::Vector3d(-0.5, -0.5, 0), {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}};

// A plate of 1 m that faces the camera, turned in its own plane, towards a pixel off the middle.
Scene plate_before(const Camera& camera) {
  const Eigen::Vector3d direction = *bearing(camera, {260, 200});
  Pose pose;
  pose.rotation = (Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), direction) *
                   Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
  pose.translation = 2.5 * direction;
  Scene scene = coverage_scene(plate(1), pose, 400);
  scene.camera = camera;
  scene.samples_per_pixel = 64;
  return scene;
}

Eigen::Vector2d pixel_of(const Scene& scene, const Eigen::Vector3d& point) {
  return project(scene.camera, scene.cam_from_target * point).value();
}

// Where an edge of the plate crosses the row or column `at` of `axis`: by bisection along it.
Eigen::Vector2d crossing(const Scene& scene, Eigen::Vector3d low, Eigen::Vector3d high, int axis,
                         double at) {
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d middle = (low + high) / 2;
    (pixel_of(scene, middle)[axis] < at ? low : high) = middle;
  }
  return pixel_of(scene, low);
}

// The plane of rays through an edge as the image has it: its unit normal.
Eigen::Vector3d measured_plane(const Scene& scene, const cv::Mat& image, int edge) {
  constexpr int kReach = 6;     // pixels summed to either side
  constexpr double kEndPx = 9;  // stay away from the corners
  Eigen::Vector3d a = kCorners[static_cast<size_t>(edge)];
  Eigen::Vector3d b = kCorners[static_cast<size_t>((edge + 1) % 4)];
  const Eigen::Vector2d chord = pixel_of(scene, b) - pixel_of(scene, a);
  const int along = std::abs(chord.y()) > std::abs(chord.x()) ? 1 : 0;
  const int across = 1 - along;
  if (chord[along] < 0) std::swap(a, b);
  const bool is_inside_above = pixel_of(scene, {0, 0, 0})[across] >
                               pixel_of(scene, a)[across] / 2 + pixel_of(scene, b)[across] / 2;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  int points = 0;
  const double last = pixel_of(scene, b)[along] - kEndPx;
  for (double step = std::ceil(pixel_of(scene, a)[along] + kEndPx); step <= last; ++step) {
    const Eigen::Vector2d expected = crossing(scene, a, b, along, step);
    const int centre = static_cast<int>(std::lround(expected[across]));
    const int place = static_cast<int>(step);
    double covered = 0;
    for (int j = centre - kReach; j <= centre + kReach; ++j) {
      covered += across == 0 ? image.at<float>(place, j) : image.at<float>(j, place);
    }
    Eigen::Vector2d point;
    point[along] = step;
    point[across] =
        is_inside_above ? centre + kReach + 0.5 - covered : centre - kReach - 0.5 + covered;
    const Eigen::Vector3d ray = bearing(scene.camera, point).value();
    scatter += ray * ray.transpose();
    ++points;
  }
  EXPECT_GT(points, 40);
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
}

// How far the worst corner of the plate lies from where a camera projects it.
double worst_corner_px(const Scene& scene, const cv::Mat& image) {
  double worst = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const Eigen::Vector3d before = measured_plane(scene, image, (corner + 3) % 4);
    const Eigen::Vector3d after = measured_plane(scene, image, corner);
    Eigen::Vector3d ray = before.cross(after);
    if (ray.z() < 0) ray = -ray;
    const Eigen::Vector2d measured = project(scene.camera, ray).value();
    const Eigen::Vector2d expected = pixel_of(scene, kCorners[static_cast<size_t>(corner)]);
    worst = std::max(worst, (measured - expected).norm());
  }
  return worst;
}

class DrawnLens : public testing::TestWithParam<NamedCamera> {};

TEST_P(DrawnLens, HasCornersWhereItProjectsThem) {
  const Scene scene = plate_before(GetParam().camera);
  EXPECT_LT(worst_corner_px(scene, Renderer().render_linear(scene)), kPromisePx);
}

TEST_P(DrawnLens, IsNoOther) {
  Scene scene = plate_before(GetParam().camera);
  const cv::Mat image = Renderer().render_linear(scene);
  // Two thousandths of the focal length are a third of a pixel at the plate.
  scene.camera.fx_px *= 1.002;
  EXPECT_GT(worst_corner_px(scene, image), 5 * kPromisePx);
}

INSTANTIATE_TEST_SUITE_P(Cameras, DrawnLens, testing::ValuesIn(cameras_with_lenses()),
                         [](const auto& camera) {
                           std::string name = camera.param.name;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

TEST(Fisheye, ShowsNothingBeyondNinetyDegrees) {
  // Its image reaches 127 degrees from the axis; a wall fills all that lies before the camera.
  Scene scene = coverage_scene(plate(200), at(0, 0, 0.5));
  scene.camera = centred_camera(160, 120, 45);
  scene.camera.lens = KannalaBrandt{};
  scene.samples_per_pixel = 1;
  const cv::Mat image = Renderer().render_linear(scene);
  EXPECT_EQ(image.at<float>(60, 80), 1);
  EXPECT_EQ(image.at<float>(60, 80 + 67), 1) << "86 degrees";
  EXPECT_EQ(image.at<float>(60, 80 + 73), 0) << "94 degrees";
  EXPECT_EQ(image.at<float>(1, 1), 0);
}

}  // namespace
}  // namespace sightline
