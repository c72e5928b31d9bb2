// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/pose.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

Pose draw_pose(Draw& draw) {
  return {draw.rotation(), 10 * draw.vector()};
}

TEST(Pose, ComposesAsFramesCancel) {
  Draw draw(1);
  for (int i = 0; i < 100; ++i) {
    const Pose b_from_a = draw_pose(draw);
    const Pose c_from_b = draw_pose(draw);
    const Eigen::Vector3d x_in_a = draw.vector();
    const Pose c_from_a = c_from_b * b_from_a;
    EXPECT_TRUE(is_matrix_near(c_from_a * x_in_a, c_from_b * (b_from_a * x_in_a), 1e-13));
  }
}

TEST(Pose, CompositionHasAnOrder) {
  const Pose turn = {rotation_from_vector({0, 0, kPi / 2}), Eigen::Vector3d::Zero()};
  const Pose shift = {Eigen::Matrix3d::Identity(), {1, 0, 0}};
  EXPECT_TRUE(is_matrix_near((turn * shift).translation, Eigen::Vector3d(0, 1, 0), kEpsilon));
  EXPECT_TRUE(is_matrix_near((shift * turn).translation, Eigen::Vector3d(1, 0, 0), kEpsilon));
}

TEST(Pose, InverseUndoes) {
  Draw draw(2);
  for (int i = 0; i < 100; ++i) {
    const Pose b_from_a = draw_pose(draw);
    EXPECT_TRUE(is_pose_near(inverse(b_from_a) * b_from_a, Pose{}, kRotationRounding, 1e-13));
    EXPECT_TRUE(is_pose_near(b_from_a * inverse(b_from_a), Pose{}, kRotationRounding, 1e-13));
  }
}

TEST(Pose, ValidAreRigidTransformsOnly) {
  Draw draw(3);
  EXPECT_TRUE(is_valid(Pose{}));
  EXPECT_TRUE(is_valid(draw_pose(draw)));

  Pose stretched = draw_pose(draw);
  stretched.rotation *= 1 + 1e-8;
  EXPECT_FALSE(is_valid(stretched));

  Pose mirrored = draw_pose(draw);
  mirrored.rotation.col(0) *= -1;
  EXPECT_FALSE(is_valid(mirrored));

  for (const double bad : {kNaN, kInfinity}) {
    Pose broken = draw_pose(draw);
    broken.rotation(1, 2) = bad;
    EXPECT_FALSE(is_valid(broken));
    broken = draw_pose(draw);
    broken.translation.y() = bad;
    EXPECT_FALSE(is_valid(broken));
  }
}

TEST(Pose, ManyProductsStayValid) {
  Draw draw(4);
  Pose product;
  for (int i = 0; i < 100000; ++i) product.rotation = product.rotation * draw.rotation();
  EXPECT_TRUE(is_valid(product));
}

TEST(RotationVector, QuarterTurns) {
  Eigen::Matrix3d about_z;
  about_z << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  EXPECT_TRUE(is_matrix_near(rotation_from_vector({0, 0, kPi / 2}), about_z, kEpsilon));
  Eigen::Matrix3d about_x;
  about_x << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  EXPECT_TRUE(is_matrix_near(rotation_from_vector({kPi / 2, 0, 0}), about_x, kEpsilon));
}

TEST(RotationVector, RoundTripsAtEveryAngle) {
  Draw draw(5);
  for (const double angle_rad : {0.0, 1e-300, 1e-200, 1e-160, 1e-20, 1e-12, 1e-9, 1e-8, 1e-4, 1.0,
                                 2.0, 3.0, kPi - 1e-4, kPi - 1e-8, kPi - 1e-12}) {
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d w = angle_rad * draw.vector().normalized();
      const Eigen::Matrix3d rotation = rotation_from_vector(w);
      const Eigen::Vector3d back = vector_from_rotation(rotation);
      EXPECT_TRUE(is_valid({rotation, {}}));
      EXPECT_LE((back - w).norm(), 8 * kEpsilon * std::max(1.0, 1 / kPi)) << angle_rad;
      if (angle_rad > 0 && angle_rad < 1e-4) {
        // Near zero it is the relative error that counts.
        EXPECT_LE((back - w).norm(), 1e-6 * angle_rad) << angle_rad;
      }
    }
  }
}

TEST(RotationVector, HalfTurnIsFoundUpToSign) {
  Draw draw(6);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d axis = draw.vector().normalized();
    const Eigen::Matrix3d rotation = 2 * axis * axis.transpose() - Eigen::Matrix3d::Identity();
    const Eigen::Vector3d w = vector_from_rotation(rotation);
    EXPECT_NEAR(w.norm(), kPi, kRotationRounding);
    EXPECT_LE(w.normalized().cross(axis).norm(), kRotationRounding);
  }
}

TEST(RotationVector, LengthNeverExceedsPi) {
  const Eigen::Vector3d w = vector_from_rotation(rotation_from_vector({0, 0, 1.5 * kPi}));
  EXPECT_TRUE(is_matrix_near(w, Eigen::Vector3d(0, 0, -0.5 * kPi), 8 * kEpsilon));
}

TEST(GeodesicAngle, IsTheAngleOfTheDifference) {
  Draw draw(7);
  for (const double angle_rad : {0.0, 1e-15, 1e-12, 1e-8, 1e-3, 1.0, 3.0, kPi - 1e-8, kPi}) {
    for (int i = 0; i < 20; ++i) {
      const Eigen::Matrix3d a = draw.rotation();
      const Eigen::Matrix3d b = a * draw.rotation_by(angle_rad);
      EXPECT_NEAR(geodesic_angle_rad(a, b), angle_rad, 10 * kEpsilon);
      EXPECT_NEAR(geodesic_angle_rad(b, a), angle_rad, 10 * kEpsilon);
    }
  }
}

TEST(GeodesicAngle, OfOneRotationIsZero) {
  Draw draw(8);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Matrix3d a = draw.rotation();
    EXPECT_LE(geodesic_angle_rad(a, a), 4 * kEpsilon);
  }
}

TEST(Quaternion, IsScalarFirstWithPositiveScalar) {
  const Eigen::Vector4d wxyz = quaternion_wxyz(rotation_from_vector({0.6, 0, 0}));
  EXPECT_TRUE(
      is_matrix_near(wxyz, Eigen::Vector4d(std::cos(0.3), std::sin(0.3), 0, 0), 2 * kEpsilon));
  // 300 deg about z is -60 deg: the sign is turned to w >= 0.
  const Eigen::Vector4d turned = quaternion_wxyz(rotation_from_vector({0, 0, 5 * kPi / 3}));
  EXPECT_TRUE(is_matrix_near(turned, Eigen::Vector4d(std::cos(kPi / 6), 0, 0, -0.5), 4 * kEpsilon));
}

TEST(Quaternion, RoundTripsAndForgetsLengthAndSign) {
  Draw draw(9);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Matrix3d rotation = draw.rotation();
    const Eigen::Vector4d wxyz = quaternion_wxyz(rotation);
    EXPECT_GE(wxyz[0], 0);
    EXPECT_NEAR(wxyz.norm(), 1, 4 * kEpsilon);
    for (const double factor : {1.0, -1.0, 7.0, 1e-200, 1e200}) {
      EXPECT_TRUE(is_rotation_near(rotation_from_quaternion_wxyz(factor * wxyz), rotation,
                                   kRotationRounding));
    }
  }
}

TEST(Matchers, RejectNaN) {
  Pose broken;
  broken.translation.x() = kNaN;
  EXPECT_FALSE(is_pose_near(broken, Pose{}, 1, 1));
  EXPECT_FALSE(is_matrix_near(broken.translation, Eigen::Vector3d(0, 0, 0), 1));
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation(0, 0) = kNaN;
  EXPECT_FALSE(is_rotation_near(rotation, Eigen::Matrix3d::Identity(), 1));
  EXPECT_TRUE(is_pose_near(Pose{}, Pose{}, 0, 0));
}

}  // namespace
}  // namespace sightline
