// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Errors of poses against cases worked by hand.
#include "eval/metrics/pose_errors.h"

#include <array>
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "eval/datasets/bop/read.h"
#include "eval/metrics/vsd.h"
#include "renderer/truth.h"
#include "tests/eval/cube_of_100_mm.h"

namespace sightline {
namespace {

// Every vertex moves by |(3, 4, 0)| = 5 mm; on the near face, 950 mm away, that is 5 x 500 / 950
// px.
TEST(BopPoseErrors, OfATranslation) {
  const auto points = cube_points();
  const Pose truth = at_1000_mm();
  const Pose estimated = shifted(truth, {3, 4, 0});
  EXPECT_NEAR(mssd(points, estimated, truth), 5, kRounding);
  EXPECT_NEAR(add_distance(points, estimated, truth), 5, kRounding);
  EXPECT_NEAR(adi_distance(points, estimated, truth), 5, kRounding);
  EXPECT_NEAR(mspd_px(points, k_of(500, 320), estimated, truth, kNoSymmetry), 2500.0 / 950,
              kRounding);
}

// By one edge: ADD is 100 mm. Four of the true corners coincide with estimated ones, the other four
// are 100 mm from the nearest: ADI is 50 mm.
TEST(BopPoseErrors, AdiIsOfTheNearest) {
  const auto points = cube_points();
  const Pose estimated = shifted(at_1000_mm(), {100, 0, 0});
  EXPECT_NEAR(add_distance(points, estimated, at_1000_mm()), 100, kRounding);
  EXPECT_NEAR(adi_distance(points, estimated, at_1000_mm()), 50, kRounding);
}

// A quarter turn about z takes each corner to its neighbour, 100 mm away, and the cube to itself.
TEST(BopPoseErrors, OfARotationWithAndWithoutSymmetry) {
  const auto points = cube_points();
  const Pose truth = at_1000_mm(rotation_from_vector({0.3, -0.2, 0.5}));
  const Pose estimated{truth.rotation * turn_z(std::numbers::pi / 2), truth.translation};
  EXPECT_NEAR(mssd(points, estimated, truth), 100, kRounding);
  EXPECT_NEAR(add_distance(points, estimated, truth), 100, kRounding);
  EXPECT_NEAR(adi_distance(points, estimated, truth), 0, kRounding);
  EXPECT_GT(mspd_px(points, k_of(500, 320), estimated, truth, kNoSymmetry), 40);
  const auto symmetries =
      bop_symmetries(R"({"symmetries_discrete": [[0,-1,0,0, 1,0,0,0, 0,0,1,0, 0,0,0,1]]})");
  EXPECT_NEAR(mssd(points, estimated, nearest_alike(points, estimated, truth, symmetries)), 0,
              kRounding);
  EXPECT_NEAR(mspd_px(points, k_of(500, 320), estimated, truth, symmetries), 0, kRounding);
  EXPECT_NEAR(add_distance(points, estimated, truth), 100, kRounding);  // which knows no symmetry
  // Without tilt, the near face's corners move by 100 mm at 950 mm.
  const Pose turned = at_1000_mm(turn_z(std::numbers::pi / 2));
  EXPECT_NEAR(mspd_px(points, k_of(500, 320), turned, at_1000_mm(), kNoSymmetry), 50000.0 / 950,
              kRounding);
}

// A cylinder's rims (radius 50 mm), turned by 1 rad about its axis: 50 steps of 2 pi / 315 leave
// 1 - 50 x 2 pi / 315 = 0.0026697 rad, a chord of 2 x 50 sin(0.0026697 / 2) = 0.133483 mm.
TEST(BopPoseErrors, OfAContinuousSymmetry) {
  Eigen::Matrix3Xd points(3, 720);
  for (int i = 0; i < 720; ++i) {
    const double angle = std::numbers::pi * i / 360;
    points.col(i) << 50 * std::cos(angle), 50 * std::sin(angle), (i % 2 ? 80 : -80);
  }
  const Pose turned = at_1000_mm(turn_z(1));
  const auto symmetries =
      bop_symmetries(R"({"symmetries_continuous": [{"axis": [0,0,1], "offset": [0,0,0]}]})");
  const double left_rad = 1 - 50 * 2 * std::numbers::pi / 315;
  const double chord_mm = 100 * std::sin(left_rad / 2);
  EXPECT_NEAR(chord_mm, 0.133, 1e-3);
  EXPECT_NEAR(mssd(points, turned, nearest_alike(points, turned, at_1000_mm(), symmetries)),
              chord_mm, kRounding);
  EXPECT_NEAR(mssd(points, turned, at_1000_mm()), 100 * std::sin(0.5), kRounding);
}

// Turned by any angle about an axis of its object, a pose comes back to what it was.
TEST(BopPoseErrors, OfATurnAboutAnAxisBetweenItsSteps) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 2) / 3;
  const Eigen::Vector3d point(10, -20, 30);
  const Pose truth = at_1000_mm(rotation_from_vector({0.3, -0.2, 0.5}));
  for (const double angle_rad : {-2.5, -0.004, 0.0, 0.7, 3.0}) {
    const Eigen::Matrix3d turn = rotation_from_vector(angle_rad * axis);
    const Pose turned = truth * Pose{turn, point - turn * point};
    const Pose found = turned_towards(turned, truth, axis, point);
    EXPECT_TRUE(found.rotation.isApprox(turned.rotation, 1e-12)) << angle_rad;
    EXPECT_LT((found.translation - turned.translation).norm(), kRounding) << angle_rad;
    EXPECT_FALSE(angle_rad > 0 && turned_towards(turned, truth, Eigen::Vector3d::UnitX(), point)
                                      .rotation.isApprox(turned.rotation, 1e-3));
  }
}

// ---- other benchmarks

// |(3, 4, 0)| = 5 mm of 1000 mm; all vertices at z = 950 or 1050 mm: 2500 / 950 and 2500 / 1050 px,
// four each.
TEST(OtherPoseErrors, OfATranslation) {
  const Pose truth = at_1000_mm();
  const Pose estimated = shifted(truth, {3, 4, 0});
  EXPECT_NEAR(projection_px(cube_points(), k_of(500, 320), estimated, truth),
              (2500.0 / 950 + 2500.0 / 1050) / 2, kRounding);
  EXPECT_NEAR(speed_score(estimated, truth), 0.005, 1e-15);
  EXPECT_NEAR(speed_plus_score(estimated, truth), 0.005, 1e-15);
  EXPECT_EQ(speed_plus_score(shifted(truth, {0, 0, 2.172}), truth), 0);
  EXPECT_NEAR(speed_plus_score(shifted(truth, {0, 0, 2.174}), truth), 0.002174, 1e-15);
}

TEST(OtherPoseErrors, OfARotationEachThresholdForItself) {
  const Pose truth = at_1000_mm();
  const auto turned = [](double angle_deg) {
    return at_1000_mm(turn_z(angle_deg * std::numbers::pi / 180));
  };
  EXPECT_NEAR(speed_score(turned(0.168), truth), 0.168 * std::numbers::pi / 180, 1e-12);
  EXPECT_EQ(speed_plus_score(turned(0.168), truth), 0);
  EXPECT_NEAR(speed_plus_score(turned(0.170), truth), 0.170 * std::numbers::pi / 180, 1e-12);
  // The angle counts, the distance beside it does not.
  EXPECT_NEAR(speed_plus_score(shifted(turned(90), {2, 0, 0}), truth), std::numbers::pi / 2, 1e-12);
  EXPECT_TRUE(is_within_5deg_5cm(shifted(turned(4.99), {0, 0, 49.9}), truth));
  EXPECT_FALSE(is_within_5deg_5cm(turned(5.01), truth));
  EXPECT_FALSE(is_within_5deg_5cm(shifted(truth, {0, 0, 50.1}), truth));
}

// ---- through a camera with its lens

// As above, but in metres, from a mesh, and with a vertex of the estimate behind the camera.
TEST(VertexErrors, AreThoseOfBopButThroughTheLens) {
  Mesh mesh;
  const auto points = cube_points();  // a loop over a temporary's columns would outlive it
  for (const auto& point : points.colwise()) mesh.vertices.emplace_back(1e-3 * point);
  const Pose truth{Eigen::Matrix3d::Identity(), {0, 0, 1}};
  const Pose estimated = shifted(truth, {0.003, 0.004, 0});
  Camera camera = centred_camera(640, 640, 500);
  const VertexErrors errors = vertex_errors(vertices_of(mesh), camera, estimated, truth);
  EXPECT_NEAR(errors.add, 0.005, kRounding);
  EXPECT_NEAR(errors.mssd, 0.005, kRounding);
  EXPECT_NEAR(errors.mspd_px, 2500.0 / 950, kRounding);
  std::get<BrownConrady>(camera.lens).k1 = 0.5;
  EXPECT_GT(vertex_errors(vertices_of(mesh), camera, estimated, truth).mspd_px, 2500.0 / 950);
  const Pose behind = shifted(truth, {0, 0, -0.96});
  EXPECT_TRUE(std::isinf(vertex_errors(vertices_of(mesh), camera, behind, truth).mspd_px));
}

TEST(VertexErrors, OfABodyThatReachesBehindTheCameraAreOfWhatIsInFront) {
  // Of a truth with one vertex 1 m before the camera and one behind, the first alone has a pixel.
  Mesh mesh;
  mesh.vertices = {{0, 0, 1}, {0, 0, -1}};
  const Pose truth;
  const Pose estimated = shifted(truth, {0.002, 0, 0});
  const Camera camera = centred_camera(640, 640, 500);
  EXPECT_NEAR(vertex_errors(vertices_of(mesh), camera, estimated, truth).mspd_px, 1, kRounding);
  const std::vector<Pose> itself(1);
  EXPECT_NEAR(least_mspd_px(vertices_of(mesh), camera, estimated, truth, itself), 1, kRounding);
  const Pose all_behind = shifted(truth, {0, 0, -2});
  EXPECT_TRUE(std::isinf(vertex_errors(vertices_of(mesh), camera, all_behind, truth).mspd_px));
  EXPECT_TRUE(std::isinf(vertex_errors(vertices_of(mesh), camera, truth, all_behind).mspd_px));
}

// ---- VSD

// A plane at z = 0 that fills every image.
Mesh plane() {
  Mesh mesh;
  mesh.vertices = {{-9e3, -9e3, 0}, {9e3, -9e3, 0}, {9e3, 9e3, 0}, {-9e3, 9e3, 0}};
  mesh.triangles = {{.vertex = {0, 1, 2}}, {.vertex = {0, 2, 3}}};
  mesh.parts.resize(1);
  return mesh;
}

cv::Mat plane_seen(double z_mm, double focal_px) {
  const Camera camera = centred_camera(64, 64, focal_px);
  return distances_of_depth(
      depth_alone(plane(), camera, {Eigen::Matrix3d::Identity(), {0, 0, z_mm}}),
      k_of(focal_px, 31.5));
}

// A narrow camera, so that 20 mm in depth are 20 mm along every ray but for 0.1 %.
TEST(BopVsd, OfAPlaneMovedInDepthIsZeroBelowTauAndOneAbove) {
  const cv::Mat truth = plane_seen(1000, 1000);
  for (const double z_mm : {980.0, 1020.0}) {
    const auto errors =
        vsd(truth, truth, plane_seen(z_mm, 1000), 15, std::array{10.0, 19.9, 20.1, 50.0});
    EXPECT_THAT(errors, testing::ElementsAre(1, 1, 0, 0)) << z_mm;
  }
}

// A wide one: along a ray (x, y, 1) they are 20 sqrt(1 + x^2 + y^2) mm. Not below 30 mm where
// x^2 + y^2 >= 1.25.
TEST(BopVsd, IsOfDistancesAlongTheRay) {
  const cv::Mat truth = plane_seen(1000, 32);
  int above = 0;
  for (int v = 0; v < 64; ++v) {
    for (int u = 0; u < 64; ++u) {
      above += std::pow((u - 31.5) / 32, 2) + std::pow((v - 31.5) / 32, 2) >= 1.25;
    }
  }
  ASSERT_GT(above, 0);
  const auto errors = vsd(truth, truth, plane_seen(1020, 32), 15, std::array{30.0});
  EXPECT_NEAR(errors[0], above / 4096.0, kRounding);
}

// Left half: something 100 mm before the plane hides it. An estimate 300 mm nearer is before that,
// so it is visible everywhere, and wrong there; one that equals the truth is hidden with it.
TEST(BopVsd, LeavesOutWhatIsHidden) {
  const cv::Mat truth = plane_seen(1000, 1000);
  cv::Mat test = truth.clone();
  test.colRange(0, 32) -= 100;
  EXPECT_EQ(vsd(test, truth, truth, 15, std::array{20.0})[0], 0);
  EXPECT_EQ(vsd(test, truth, plane_seen(700, 1000), 15, std::array{500.0})[0], 0.5);
  EXPECT_EQ(vsd(test, truth, plane_seen(700, 1000), 150, std::array{500.0})[0], 0);  // all visible
  test.colRange(0, 32) = 0;  // no depth there: taken as visible
  EXPECT_EQ(vsd(test, truth, plane_seen(700, 1000), 15, std::array{500.0})[0], 0);
}

TEST(BopVsd, IsOneOfNothing) {
  const cv::Mat truth = plane_seen(1000, 1000);
  const cv::Mat nothing = cv::Mat::zeros(64, 64, CV_64F);
  EXPECT_EQ(cv::norm(plane_seen(-1000, 1000), nothing), 0);  // behind the camera
  EXPECT_EQ(vsd(truth, truth, nothing, 15, std::array{500.0})[0], 1);
  EXPECT_EQ(vsd(truth, nothing, nothing, 15, std::array{500.0})[0], 1);
}

}  // namespace
}  // namespace sightline
