// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <gtest/gtest.h>

#include "pose/absolute_orientation.h"
#include "pose/kernels/orientation_kernels.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

using Matrix3l = Eigen::Matrix<long double, 3, 3>;
using Vector3l = Eigen::Matrix<long double, 3, 1>;

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

// The closed form's error grows with the inverse square of the gap; what comes out must be as good
// as the SVD at every gap.
class GapTest : public testing::TestWithParam<double> {};

TEST_P(GapTest, IsAsAccurateAsTheSvd) {
  constexpr int kDraws = 1000;
  constexpr double kAllowedRatio = 2;
  constexpr std::size_t kMaxVersions = 4;
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
    std::array<double, kMaxVersions> version_sum2 = {};  // of the code for each kind of CPU
    for (int i = 0; i < kDraws; ++i) {
      const Matrix3l u = draw_rotation_long(draw);
      const Matrix3l v = draw_rotation_long(draw);
      const Matrix3l product = u * s.asDiagonal() * v.transpose();
      const Eigen::Matrix3d b = product.cast<double>();
      const Matrix3l reference = reference_rotation(b, u * v.transpose());
      const OrientationEstimate estimate = fast_rotation(b);
      ASSERT_EQ(estimate.status, OrientationStatus::kOk) << "singular values " << s.transpose();
      ASSERT_TRUE(is_valid(estimate.b_from_a));
      for (std::size_t rank = 0; orientation_kernels(rank); ++rank) {
        ASSERT_LT(rank, kMaxVersions);
        const ClosedForm closed = orientation_kernels(rank)->rotation(b.data());
        if (!closed.is_precise) continue;
        const Eigen::Matrix3d rotation(closed.rotation);
        version_sum2[rank] += std::pow(error_rad(rotation, reference), 2);
      }
      sum2 += std::pow(error_rad(estimate.b_from_a.rotation, reference), 2);
      svd_sum2 += std::pow(error_rad(rotation_by_svd(b), reference), 2);
    }
    EXPECT_LE(std::sqrt(sum2), kAllowedRatio * std::sqrt(svd_sum2))
        << "singular values " << s.transpose();
    for (const double of_version : version_sum2) {
      EXPECT_LE(std::sqrt(of_version), kAllowedRatio * std::sqrt(svd_sum2));
    }
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

}  // namespace
}  // namespace sightline
