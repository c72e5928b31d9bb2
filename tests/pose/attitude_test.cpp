// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/attitude.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

Attitude in_degrees(double pitch, double yaw, double roll) {
  return {pitch * kDegree, yaw * kDegree, roll * kDegree};
}

TEST(Attitude, IsRollAfterYawAfterPitch) {
  const Attitude theta = in_degrees(-20, 30, 40);
  const Eigen::Matrix3d expected = (Eigen::AngleAxisd(theta.roll_rad, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(theta.yaw_rad, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(theta.pitch_rad, Eigen::Vector3d::UnitX()))
                                       .toRotationMatrix();
  EXPECT_TRUE(is_rotation_near(rotation_from_attitude(theta), expected, kRotationRounding));
}

TEST(Attitude, SingleAnglesTurnAboutTheirAxes) {
  EXPECT_TRUE(is_rotation_near(rotation_from_attitude({0.3, 0, 0}),
                               rotation_from_vector({0.3, 0, 0}), kRotationRounding));
  EXPECT_TRUE(is_rotation_near(rotation_from_attitude({0, 0.3, 0}),
                               rotation_from_vector({0, 0.3, 0}), kRotationRounding));
  EXPECT_TRUE(is_rotation_near(rotation_from_attitude({0, 0, 0.3}),
                               rotation_from_vector({0, 0, 0.3}), kRotationRounding));
}

TEST(Attitude, RoundTripsAwayFromGimbalLock) {
  Draw draw(1);
  for (int i = 0; i < 500; ++i) {
    const Attitude theta = {draw.uniform(-kPi, kPi), draw.uniform(-1.5, 1.5),
                            draw.uniform(-kPi, kPi)};
    const Attitude back = attitude_from_rotation(rotation_from_attitude(theta));
    const double tolerance = kRotationRounding / std::cos(theta.yaw_rad);
    EXPECT_NEAR(back.pitch_rad, theta.pitch_rad, tolerance);
    EXPECT_NEAR(back.yaw_rad, theta.yaw_rad, tolerance);
    EXPECT_NEAR(back.roll_rad, theta.roll_rad, tolerance);
  }
}

TEST(Attitude, GivesBackTheRotationEvenNearGimbalLock) {
  Draw draw(2);
  for (const double from_lock : {1e-3, 1e-7, 1e-10, 1e-14, 1e-15, 1e-16, 0.0}) {
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Matrix3d rotation = rotation_from_attitude(
          {draw.uniform(-3, 3), side * (kPi / 2 - from_lock), draw.uniform(-3, 3)});
      const Attitude theta = attitude_from_rotation(rotation);
      EXPECT_TRUE(is_rotation_near(rotation_from_attitude(theta), rotation, 2 * kRotationRounding));
    }
  }
}

TEST(Attitude, RollIsZeroInGimbalLock) {
  const Attitude theta = attitude_from_rotation(rotation_from_attitude({0.4, kPi / 2, 0.1}));
  EXPECT_EQ(theta.roll_rad, 0);
  EXPECT_NEAR(theta.pitch_rad, 0.3, kRotationRounding);
  const Attitude below = attitude_from_rotation(rotation_from_attitude({0.4, -kPi / 2, 0.1}));
  EXPECT_EQ(below.roll_rad, 0);
  EXPECT_NEAR(below.pitch_rad, 0.5, kRotationRounding);
}

TEST(AttitudeError, IsTheRootMeanSquareOfTheAngles) {
  const Eigen::Matrix3d truth = rotation_from_attitude(in_degrees(10, 20, 30));
  const Eigen::Matrix3d estimated = rotation_from_attitude(in_degrees(11, 18, 32));
  EXPECT_NEAR(attitude_error_rad(estimated, truth), std::sqrt((1 + 4 + 4) / 3.0) * kDegree,
              kRotationRounding);
  EXPECT_EQ(attitude_error_rad(truth, truth), 0);
}

TEST(AttitudeError, WrapsAroundTheHalfTurn) {
  const Eigen::Matrix3d truth = rotation_from_attitude(in_degrees(179, 0, -179));
  const Eigen::Matrix3d estimated = rotation_from_attitude(in_degrees(-179, 0, 179));
  EXPECT_NEAR(attitude_error_rad(estimated, truth), std::sqrt(8 / 3.0) * kDegree,
              kRotationRounding);
}

TEST(TranslationError, IsTheRootMeanSquareOverTheRange) {
  // |truth| = 3 m, error (0, 0.3, 0.4): 0.5 / sqrt(3) / 3.
  EXPECT_NEAR(translation_error_fraction({1, 2.3, 2.4}, {1, 2, 2}), 0.5 / std::sqrt(3.0) / 3,
              kEpsilon);
  EXPECT_EQ(translation_error_fraction({1, 2, 2}, {1, 2, 2}), 0);
}

}  // namespace
}  // namespace sightline
