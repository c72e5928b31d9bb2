// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "pose/absolute_orientation.h"
#include "tests/pose/matchers.h"
#include "tests/pose/orientation/clouds.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

TEST(AbsoluteOrientation, IsExactOnExactData) {
  Draw draw(6);
  for (const int n : {3, 4, 8, 28, 1000}) {
    for (int i = 0; i < 20; ++i) {
      const Pose b_from_a = {draw.rotation(), draw.in_box(100)};
      const Cloud cloud = draw_cloud(n, {10, 10, 10}, 0, b_from_a, draw);
      const OrientationEstimate estimate = fast_absolute_orientation(cloud.in_a, cloud.in_b);
      ASSERT_EQ(estimate.status, OrientationStatus::kOk);
      // 100 m and n = 3 now and then thin: coordinates round to 1e-14 m.
      EXPECT_TRUE(is_pose_near(estimate.b_from_a, b_from_a, 1e-11, 1e-10));
    }
  }
}

TEST(AbsoluteOrientation, EqualsUmeyamaOnNoisyData) {
  Draw draw(7);
  for (const int n : {3, 5, 10, 28}) {
    for (int i = 0; i < 100; ++i) {
      const Pose b_from_a = {i % 2 ? draw.rotation() : draw.rotation_by(kPi), draw.in_box(100)};
      Cloud cloud = draw_cloud(n, {10, 10, 10}, 0, b_from_a, draw);
      for (Eigen::Vector3d& x : cloud.in_b) x += 0.5 * draw.vector();
      const OrientationEstimate estimate = fast_absolute_orientation(cloud.in_a, cloud.in_b);
      ASSERT_EQ(estimate.status, OrientationStatus::kOk);
      EXPECT_TRUE(is_pose_near(estimate.b_from_a, umeyama_pose(cloud), 1e-11, 1e-9));
    }
  }
}

TEST(AbsoluteOrientation, CoplanarPointsAreEnough) {
  Draw draw(8);
  const Pose b_from_a = {draw.rotation(), draw.in_box(100)};
  const Cloud cloud = draw_cloud(6, {10, 5, 0}, 0, b_from_a, draw);
  const OrientationEstimate estimate = fast_absolute_orientation(cloud.in_a, cloud.in_b);
  ASSERT_EQ(estimate.status, OrientationStatus::kOk);
  EXPECT_TRUE(is_pose_near(estimate.b_from_a, b_from_a, 1e-13, 1e-12));
}

TEST(AbsoluteOrientation, MirroredPointsGiveTheBestRotationNotAReflection) {
  Draw draw(9);
  for (int i = 0; i < 50; ++i) {
    Cloud cloud = draw_cloud(8, {10, 7, 4}, 0, {draw.rotation(), draw.in_box(10)}, draw);
    for (Eigen::Vector3d& x : cloud.in_b) x.x() = -x.x();
    const OrientationEstimate estimate = fast_absolute_orientation(cloud.in_a, cloud.in_b);
    ASSERT_EQ(estimate.status, OrientationStatus::kOk);
    EXPECT_TRUE(is_pose_near(estimate.b_from_a, umeyama_pose(cloud), 1e-11, 1e-9));
  }
}

TEST(AbsoluteOrientation, LargeOffsetsCostOnlyTheDigitsOfTheCoordinates) {
  Draw draw(10);
  const Pose b_from_a = {draw.rotation(), {1e6, -1e6, 2e6}};
  const Cloud cloud = draw_cloud(10, {10, 10, 10}, 1e6, b_from_a, draw);
  const OrientationEstimate estimate = fast_absolute_orientation(cloud.in_a, cloud.in_b);
  ASSERT_EQ(estimate.status, OrientationStatus::kOk);
  // Coordinates of 1e6 m round to 1e-10 m, over a 10 m cloud 1e-11 rad; that times 1e6 m of lever.
  EXPECT_TRUE(is_pose_near(estimate.b_from_a, b_from_a, 1e-10, 1e-4));
  for (std::size_t i = 0; i < cloud.in_a.size(); ++i) {
    EXPECT_TRUE(is_matrix_near(estimate.b_from_a * cloud.in_a[i], cloud.in_b[i], 4e-9));
  }
}

TEST(AbsoluteOrientation, CollinearAndCoincidentPointsAreFlagged) {
  Draw draw(11);
  for (const double offset : {0.0, 1.0, 1e3}) {
    const Pose b_from_a = {draw.rotation(), draw.in_box(100)};
    const Cloud line = draw_cloud(5, {10, 0, 0}, offset, b_from_a, draw);
    EXPECT_EQ(fast_absolute_orientation(line.in_a, line.in_b).status,
              OrientationStatus::kDegenerate);
    const Cloud rod = draw_cloud(5, {10, 0.01, 0.01}, offset, b_from_a, draw);
    EXPECT_EQ(fast_absolute_orientation(rod.in_a, rod.in_b).status, OrientationStatus::kOk);
  }
  const Points spot(4, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(fast_absolute_orientation(spot, spot).status, OrientationStatus::kDegenerate);
}

TEST(AbsoluteOrientation, TooFewOrUnmatchedPointsAreFlagged) {
  const Points two = {{0, 0, 0}, {1, 0, 0}};
  const Points three = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(fast_absolute_orientation(Points{}, Points{}).status, OrientationStatus::kTooFewPoints);
  EXPECT_EQ(fast_absolute_orientation(two, two).status, OrientationStatus::kTooFewPoints);
  EXPECT_EQ(fast_absolute_orientation(two, three).status, OrientationStatus::kTooFewPoints);
  EXPECT_EQ(fast_absolute_orientation(three, three).status, OrientationStatus::kOk);
}

TEST(AbsoluteOrientation, CoordinatesThatAreNotFiniteAreFlagged) {
  const Points good = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const double bad : {kNaN, kInfinity}) {
    Points broken = good;
    broken[2].y() = bad;
    EXPECT_EQ(fast_absolute_orientation(broken, good).status, OrientationStatus::kNotFinite);
    EXPECT_EQ(fast_absolute_orientation(good, broken).status, OrientationStatus::kNotFinite);
  }
}

TEST(AbsoluteOrientation, AFirstPointFarOutCostsNoDigits) {
  Draw draw(21);
  const Pose b_from_a = {draw.rotation(), {1, 2, 3}};
  Cloud cloud = draw_cloud(1000, {10, 10, 10}, 0, b_from_a, draw);
  for (Eigen::Vector3d& x : cloud.in_b) x += 0.1 * draw.vector();
  Cloud turned_round = cloud;
  cloud.in_a.front() = {1e5, 0, 0};
  cloud.in_b.front() = b_from_a * cloud.in_a.front();
  turned_round.in_a.assign(cloud.in_a.rbegin(), cloud.in_a.rend());
  turned_round.in_b.assign(cloud.in_b.rbegin(), cloud.in_b.rend());
  const OrientationEstimate first = fast_absolute_orientation(cloud.in_a, cloud.in_b);
  const OrientationEstimate last = fast_absolute_orientation(turned_round.in_a, turned_round.in_b);
  ASSERT_EQ(first.status, OrientationStatus::kOk);
  // About the line to the far point only the others tell: 1e5 of 1e10 in B, a gap of 1e-5.
  EXPECT_TRUE(is_pose_near(first.b_from_a, umeyama_pose(cloud), 1e-9, 1e-7));
  EXPECT_TRUE(is_pose_near(first.b_from_a, last.b_from_a, 1e-9, 1e-7));
}

TEST(AbsoluteOrientation, WhatTheRoundingOfFloatsCouldHaveMadeIsNoGap) {
  Draw draw(38);
  for (const double offset : {1e3, 1e4, 1e5, 1e6}) {
    for (int i = 0; i < 20; ++i) {
      const Pose b_from_a = {draw.rotation(), draw.in_box(100)};
      const Cloud line = draw_cloud(5, {10, 0, 0}, offset, b_from_a, draw);
      EXPECT_EQ(fast_absolute_orientation(in_float(line.in_a), in_float(line.in_b)).status,
                OrientationStatus::kDegenerate)
          << offset;
      const Cloud cube = draw_cloud(8, {10, 10, 10}, offset, b_from_a, draw);
      EXPECT_EQ(fast_absolute_orientation(in_float(cube.in_a), in_float(cube.in_b)).status,
                OrientationStatus::kOk)
          << offset;
    }
  }
}

}  // namespace
}  // namespace sightline
