// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// OpenCV's own lenses put random points where ours do, and undo them as ours do.
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "pose/lenses/catalogue.h"
#include "tests/pose/lenses/lenses_for_tests.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

constexpr double kSamePixel = 1e-9;  // both in double precision, 1000 px
constexpr double kSameRay = 1e-7;    // OpenCV's iteration ends at a tolerance that is given

cv::Matx33d matrix_of(const Camera& camera) {
  return {camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1};
}

bool is_fisheye(const Camera& camera) {
  return std::holds_alternative<KannalaBrandt>(camera.lens);
}

std::vector<cv::Point2d> by_opencv(const Camera& camera, const std::vector<cv::Point3d>& points) {
  const std::vector<double> lens = coefficients_of(camera.lens);
  std::vector<cv::Point2d> pixels;
  const cv::Vec3d none(0, 0, 0);
  if (is_fisheye(camera)) {
    cv::fisheye::projectPoints(points, pixels, none, none, matrix_of(camera), lens,
                               camera.skew_px / camera.fx_px);
  } else {
    cv::projectPoints(points, none, none, matrix_of(camera), lens, pixels);
  }
  return pixels;
}

TEST(LensPeers, OpenCvPutsPointsAtTheSamePixels) {
  Draw draw(3);
  int fisheyes = 0, others = 0;
  for (const auto& [name, camera] : cameras_with_lenses()) {
    if (!is_fisheye(camera) && camera.skew_px != 0) continue;  // which OpenCV has not
    ++(is_fisheye(camera) ? fisheyes : others);
    std::vector<cv::Point3d> points;
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d x = draw.in_box(2) + Eigen::Vector3d(0, 0, 3.5);
      points.emplace_back(x.x(), x.y(), x.z());
    }
    const std::vector<cv::Point2d> pixels = by_opencv(camera, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto ours = project(camera, {points[i].x, points[i].y, points[i].z});
      ASSERT_TRUE(ours);
      EXPECT_TRUE(is_matrix_near(*ours, Eigen::Vector2d(pixels[i].x, pixels[i].y), kSamePixel))
          << name;
    }
    // Another lens has other pixels.
    Camera without = camera;
    without.lens = {};
    const auto straight = project(without, {points[0].x, points[0].y, points[0].z});
    EXPECT_GT((*straight - Eigen::Vector2d(pixels[0].x, pixels[0].y)).norm(), 0.1) << name;
  }
  EXPECT_EQ(fisheyes, 3);
  EXPECT_EQ(others, 3);
}

TEST(LensPeers, OpenCvUndoesLensesAsWeDo) {
  const cv::TermCriteria most(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 1000, 1e-14);
  Draw draw(4);
  for (const auto& [name, camera] : cameras_with_lenses()) {
    if (camera.skew_px != 0) continue;  // which OpenCV undoes in no function
    const std::vector<double> lens = coefficients_of(camera.lens);
    std::vector<cv::Point2d> pixels, rays;
    for (int i = 0; i < 100; ++i) {
      const double u = draw.uniform(100, 500);
      pixels.emplace_back(u, draw.uniform(80, 400));
    }
    if (is_fisheye(camera)) {
      cv::fisheye::undistortPoints(pixels, rays, matrix_of(camera), lens, cv::noArray(),
                                   cv::noArray(), most);
    } else {
      cv::undistortPoints(pixels, rays, matrix_of(camera), lens, cv::noArray(), cv::noArray(),
                          most);
    }
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const auto ours = normalised_from_pixel(camera, {pixels[i].x, pixels[i].y});
      ASSERT_TRUE(ours) << name;
      EXPECT_TRUE(is_matrix_near(*ours, Eigen::Vector2d(rays[i].x, rays[i].y), kSameRay)) << name;
    }
  }
}

}  // namespace
}  // namespace sightline
