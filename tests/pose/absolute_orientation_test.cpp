// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/absolute_orientation.h"

#include <vector>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <gtest/gtest.h>

#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

using Matrix3l = Eigen::Matrix<long double, 3, 3>;
using Vector3l = Eigen::Matrix<long double, 3, 1>;
using Points = std::vector<Eigen::Vector3d>;

Eigen::Matrix3d rotation_by_svd(const Eigen::Matrix3d& b) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(b, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV()).determinant() < 0 ? -1.0 : 1.0;
  return svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

/// The maximiser of tr(A^T B) by Newton's method in long double, from nearby.
Matrix3l reference_rotation(const Eigen::Matrix3d& b, Matrix3l a) {
  for (int i = 0; i < 5; ++i) {
    const Matrix3l m = b.cast<long double>() * a.transpose();
    const Vector3l gradient(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
    Matrix3l curvature = -0.5L * (m + m.transpose());
    curvature.diagonal().array() += m.trace();
    const Vector3l w = curvature.fullPivLu().solve(gradient) / 2;
    const Eigen::Quaternion<long double> turn(1, w.x(), w.y(), w.z());
    a = (turn * Eigen::Quaternion<long double>(a)).normalized().toRotationMatrix();
  }
  return a;
}

Matrix3l draw_rotation_long(Draw& draw) {
  return Eigen::Quaternion<long double>(draw.rotation().cast<long double>())
      .normalized()
      .toRotationMatrix();
}

double error_rad(const Eigen::Matrix3d& a, const Matrix3l& reference) {
  return static_cast<double>((a.cast<long double>() - reference).norm() / std::sqrt(2.0L));
}

struct Cloud {
  Points in_a;
  Points in_b;
  Pose b_from_a;
};

Cloud draw_cloud(int n, const Eigen::Vector3d& half_width, double offset, const Pose& b_from_a,
                 Draw& draw) {
  Cloud cloud;
  cloud.b_from_a = b_from_a;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3d x_in_a =
        half_width.cwiseProduct(draw.in_box(1)) + Eigen::Vector3d::Constant(offset);
    cloud.in_a.push_back(x_in_a);
    cloud.in_b.push_back(b_from_a * x_in_a);
  }
  return cloud;
}

Pose umeyama_pose(const Cloud& cloud) {
  const auto n = static_cast<Eigen::Index>(cloud.in_a.size());
  Eigen::Matrix3Xd a(3, n);
  Eigen::Matrix3Xd b(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    a.col(i) = cloud.in_a[static_cast<std::size_t>(i)];
    b.col(i) = cloud.in_b[static_cast<std::size_t>(i)];
  }
  const Eigen::Matrix4d transform = Eigen::umeyama(a, b, false);
  return {transform.topLeftCorner<3, 3>(), transform.topRightCorner<3, 1>()};
}

// The closed form's error grows with the inverse square of the gap; what comes out must be as good
// as the SVD at every gap.
class GapTest : public testing::TestWithParam<double> {};

TEST_P(GapTest, IsAsAccurateAsTheSvd) {
  constexpr int kDraws = 500;
  constexpr double kAllowedRatio = 2;
  const double gap = GetParam();
  // Rods, planes edge on, and mirrored clouds (det B < 0), by their singular values.
  const Vector3l rod(1, 0.6 * gap, 0.4 * gap);
  const Vector3l flat_rod(1, gap, 0);
  const Vector3l mirrored(1, 0.9, std::min(0.0, gap - 0.9));
  const Vector3l thin_mirrored(1, 1.2 * gap, -0.2 * gap);
  Draw draw(1);
  for (const Vector3l& s : {rod, flat_rod, mirrored, thin_mirrored}) {
    double sum2 = 0;
    double svd_sum2 = 0;
    for (int i = 0; i < kDraws; ++i) {
      const Matrix3l u = draw_rotation_long(draw);
      const Matrix3l v = draw_rotation_long(draw);
      const Matrix3l product = u * s.asDiagonal() * v.transpose();
      const Eigen::Matrix3d b = product.cast<double>();
      const Matrix3l reference = reference_rotation(b, u * v.transpose());
      const OrientationEstimate estimate = fast_rotation(b);
      ASSERT_EQ(estimate.status, OrientationStatus::kOk) << "singular values " << s.transpose();
      ASSERT_TRUE(is_valid(estimate.b_from_a));
      sum2 += std::pow(error_rad(estimate.b_from_a.rotation, reference), 2);
      svd_sum2 += std::pow(error_rad(rotation_by_svd(b), reference), 2);
    }
    EXPECT_LE(std::sqrt(sum2), kAllowedRatio * std::sqrt(svd_sum2))
        << "singular values " << s.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(Gaps, GapTest,
                         testing::Values(1.0, 0.3, 0.15, 0.1, 0.05, 1e-2, 1e-3, 3e-4, 1e-4, 3e-5,
                                         1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10));

TEST(FastRotation, ReturnsRotationsThemselves) {
  Draw draw(2);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Matrix3d rotation = draw.rotation();
    EXPECT_TRUE(
        is_rotation_near(fast_rotation(rotation).b_from_a.rotation, rotation, kRotationRounding));
  }
}

TEST(FastRotation, HandlesHalfTurns) {
  Draw draw(3);
  for (const double from_pi : {0.0, 1e-12, 1e-8, 1e-3}) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Matrix3d rotation = draw.rotation_by(kPi - from_pi);
      const Eigen::Matrix3d b = rotation * Eigen::Vector3d(3, 2, 1).asDiagonal();
      EXPECT_TRUE(
          is_rotation_near(fast_rotation(b).b_from_a.rotation, rotation, kRotationRounding));
    }
  }
}

TEST(FastRotation, DoesNotDependOnScale) {
  Draw draw(4);
  for (const double scale : {1e-300, 1e-20, 1e20, 1e300}) {
    const Eigen::Matrix3d rotation = draw.rotation();
    const Eigen::Matrix3d b = scale * rotation * Eigen::Vector3d(1, 0.5, 0.2).asDiagonal();
    const OrientationEstimate estimate = fast_rotation(b);
    ASSERT_EQ(estimate.status, OrientationStatus::kOk) << scale;
    EXPECT_TRUE(is_rotation_near(estimate.b_from_a.rotation, rotation, kRotationRounding));
  }
}

TEST(FastRotation, SaysWhenTheMaximiserIsNotUnique) {
  Draw draw(5);
  const Eigen::Matrix3d u = draw.rotation();
  const Eigen::Matrix3d v = draw.rotation();
  const auto status = [&](const Eigen::Vector3d& s) {
    return fast_rotation(u * s.asDiagonal() * v.transpose()).status;
  };
  EXPECT_EQ(status({1, 0, 0}), OrientationStatus::kDegenerate);       // collinear
  EXPECT_EQ(status({1, 1e-14, 0}), OrientationStatus::kDegenerate);   // to rounding
  EXPECT_EQ(status({1, 0.5, -0.5}), OrientationStatus::kDegenerate);  // mirrored, two axes alike
  EXPECT_EQ(status({0, 0, 0}), OrientationStatus::kDegenerate);
  EXPECT_EQ(status({1, 1e-10, 0}), OrientationStatus::kOk);
  EXPECT_EQ(status({1, 0.5, -0.5 + 1e-9}), OrientationStatus::kOk);
  EXPECT_EQ(status({1, 1, 1}), OrientationStatus::kOk);
}

TEST(FastRotation, RejectsWhatIsNotFinite) {
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    for (int i = 0; i < 9; ++i) {
      Eigen::Matrix3d b = Eigen::Matrix3d::Identity();
      b(i) = bad;
      EXPECT_EQ(fast_rotation(b).status, OrientationStatus::kNotFinite);
    }
  }
}

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
  EXPECT_EQ(fast_absolute_orientation({}, {}).status, OrientationStatus::kTooFewPoints);
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

}  // namespace
}  // namespace sightline
