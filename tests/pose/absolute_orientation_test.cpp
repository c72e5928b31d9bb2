// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/absolute_orientation.h"

#include <array>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <gtest/gtest.h>

#include "pose/kernels/orientation_kernels.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

using Matrix3l = Eigen::Matrix<long double, 3, 3>;
using Vector3l = Eigen::Matrix<long double, 3, 1>;
using Points = std::vector<Eigen::Vector3d>;
using FloatPoints = std::vector<Eigen::Vector3f>;
using Weights = std::vector<double>;

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

// How the sums are taken

FloatPoints in_float(const Points& points) {
  FloatPoints result;
  for (const Eigen::Vector3d& x : points) result.push_back(x.cast<float>());
  return result;
}

Points in_double(const FloatPoints& points) {
  Points result;
  for (const Eigen::Vector3f& x : points) result.push_back(x.cast<double>());
  return result;
}

void expect_sums_near(const PairSums& actual, const PairSums& expected, double n) {
  // Terms of up to 20^2, and the plain sum rounds once a point.
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      EXPECT_NEAR(actual.rows[i][j], expected.rows[i][j], 400 * n * std::sqrt(n) * kEpsilon) << n;
    }
  }
}

template <typename Scalar>
PairArrays<Scalar> arrays_of(const std::vector<Eigen::Matrix<Scalar, 3, 1>>& a,
                             const std::vector<Eigen::Matrix<Scalar, 3, 1>>& b,
                             const double* weights) {
  return {a[0].data(), b[0].data(), weights, a.size(), {1, -2, 3}, {-3, 2, 1}};
}

TEST(PairSums, EqualPlainLoops) {
  Draw draw(20);
  for (const int n : {1, 2, 3, 4, 5, 6, 7, 8, 9, 17, 100, 8191, 8192, 8193, 8194, 20001}) {
    const Cloud cloud = draw_cloud(n, {10, 9, 8}, 0, {draw.rotation(), {1, 2, 3}}, draw);
    Weights weights;
    for (int i = 0; i < n; ++i) weights.push_back(draw.uniform(0, 2));
    const double* const none = nullptr;
    for (const double* w : {none, static_cast<const double*>(weights.data())}) {
      const FloatPoints float_a = in_float(cloud.in_a);
      const FloatPoints float_b = in_float(cloud.in_b);
      const PairArrays<double> doubles = arrays_of<double>(cloud.in_a, cloud.in_b, w);
      const PairArrays<float> floats = arrays_of<float>(float_a, float_b, w);
      for (std::size_t rank = 0; orientation_kernels(rank); ++rank) {
        const OrientationKernels& kernels = *orientation_kernels(rank);
        expect_sums_near(kernels.sum_double(doubles), sum_pairs_plainly(doubles), n);
        expect_sums_near(kernels.sum_float(floats), sum_pairs_plainly(floats), n);
      }
    }
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

TEST(AbsoluteOrientation, AnyUnitOfLengthWillDo) {
  Draw draw(22);
  const Pose b_from_a = {draw.rotation(), {1, 2, 3}};
  const Cloud cloud = draw_cloud(6, {10, 10, 10}, 5, b_from_a, draw);
  for (const double unit : {1e-300, 1e-160, 1e-80, 1e-30, 1e30, 1e80, 1e160, 1e300}) {
    Cloud scaled = cloud;
    for (Eigen::Vector3d& x : scaled.in_a) x *= unit;
    for (Eigen::Vector3d& x : scaled.in_b) x *= unit;
    for (const OrientationMethod& method : orientation_methods()) {
      const OrientationEstimate estimate = method.estimate(scaled.in_a, scaled.in_b);
      ASSERT_EQ(estimate.status, OrientationStatus::kOk) << method.name << unit;
      EXPECT_TRUE(is_rotation_near(estimate.b_from_a.rotation, b_from_a.rotation, 1e-12));
      EXPECT_TRUE(is_matrix_near(estimate.b_from_a.translation / unit, b_from_a.translation, 1e-10))
          << method.name << unit;
    }
  }
}

// Every method

TEST(OrientationMethods, EqualTheFolder) {
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "pose/orientation")) {
    if (entry.path().extension() == ".cpp") files.insert(entry.path().stem());
  }
  std::set<std::string> names;
  for (const OrientationMethod& method : orientation_methods()) {
    EXPECT_TRUE(names.emplace(method.name).second) << method.name;
    EXPECT_EQ(find_orientation_method(method.name), &method);
    EXPECT_FALSE(method.summary.empty());
  }
  EXPECT_EQ(names, files);
  EXPECT_EQ(find_orientation_method("slow"), nullptr);
}

class MethodTest : public testing::TestWithParam<OrientationMethod> {
 protected:
  const OrientationMethod& method() const { return GetParam(); }
  bool is(std::string_view name) const { return method().name == name; }
  OrientationStatus status(const Points& a, const Points& b, const Weights& weights = {}) const {
    const OrientationEstimate estimate = method().estimate(a, b, weights);
    const OrientationEstimate in_floats = method().estimate(in_float(a), in_float(b), weights);
    EXPECT_EQ(in_floats.status, estimate.status);
    EXPECT_TRUE(is_valid(estimate.b_from_a) && std::isfinite(estimate.scale));
    return estimate.status;
  }
  /// direct_linear does not minimise what the others do, and a free scale shifts the translation.
  bool minimises_rigid_least_squares() const {
    return !is("direct_linear") && !is("umeyama_scaled");
  }
};

INSTANTIATE_TEST_SUITE_P(Orientation, MethodTest,
                         testing::ValuesIn(orientation_methods().begin(),
                                           orientation_methods().end()),
                         [](const auto& of) { return std::string(of.param.name); });

TEST_P(MethodTest, IsExactOnExactData) {
  Draw draw(30);
  for (const int n : {4, 5, 10, 100}) {
    for (const double offset : {0.0, 100.0}) {
      for (const double angle_rad : {0.0, 1e-8, 0.3, 2.0, kPi - 1e-3, kPi - 1e-9, kPi}) {
        const Pose b_from_a = {draw.rotation_by(angle_rad), draw.in_box(100)};
        Cloud cloud = draw_cloud(n, {10, 10, 10}, offset, b_from_a, draw);
        cloud.in_a[1] = cloud.in_a[0] + Eigen::Vector3d(5, 0, 0);  // never nearly coplanar
        cloud.in_a[2] = cloud.in_a[0] + Eigen::Vector3d(0, 5, 0);
        cloud.in_a[3] = cloud.in_a[0] + Eigen::Vector3d(0, 0, 5);
        for (int i = 0; i < n; ++i) cloud.in_b[i] = b_from_a * cloud.in_a[i];
        const OrientationEstimate estimate = method().estimate(cloud.in_a, cloud.in_b);
        ASSERT_EQ(estimate.status, OrientationStatus::kOk);
        EXPECT_TRUE(is_pose_near(estimate.b_from_a, b_from_a, 1e-12, 1e-10));
        EXPECT_NEAR(estimate.scale, 1, 1e-13);
      }
    }
  }
}

TEST_P(MethodTest, EqualsUmeyamaOnNoisyData) {
  Draw draw(31);
  for (const int n : {5, 10, 28, 300}) {
    for (int i = 0; i < 20; ++i) {
      const Pose b_from_a = {i % 2 ? draw.rotation() : draw.rotation_by(kPi), draw.in_box(100)};
      Cloud cloud = draw_cloud(n, {10, 10, 10}, 0, b_from_a, draw);
      for (Eigen::Vector3d& x : cloud.in_b) x += 0.1 * draw.vector();
      const Pose expected = umeyama_pose(cloud);
      const OrientationEstimate estimate = method().estimate(cloud.in_a, cloud.in_b);
      ASSERT_EQ(estimate.status, OrientationStatus::kOk);
      // A row of n = 5 may be thin: gaps of 0.05, where B^T B has lost the square.
      if (!is("direct_linear")) {
        EXPECT_TRUE(is_rotation_near(estimate.b_from_a.rotation, expected.rotation, 1e-11));
      }
      if (minimises_rigid_least_squares()) {
        EXPECT_TRUE(is_pose_near(estimate.b_from_a, expected, 1e-11, 1e-9));
      } else {
        EXPECT_TRUE(is_pose_near(estimate.b_from_a, expected, 1, 10));
      }
    }
  }
}

TEST_P(MethodTest, OffsetsOfAMillionCostOnlyTheDigitsOfTheCoordinates) {
  Draw draw(32);
  const Pose b_from_a = {draw.rotation(), {1e6, -1e6, 2e6}};
  const Cloud cloud = draw_cloud(20, {10, 10, 10}, 1e6, b_from_a, draw);
  const OrientationEstimate estimate = method().estimate(cloud.in_a, cloud.in_b);
  ASSERT_EQ(estimate.status, OrientationStatus::kOk);
  // As for the fast one above; the scale errs by as much as the angle and has the same lever.
  EXPECT_TRUE(is_pose_near(estimate.b_from_a, b_from_a, 1e-10, 5e-4));
}

TEST_P(MethodTest, AWeightIsANumberOfPoints) {
  Draw draw(33);
  for (int i = 0; i < 20; ++i) {
    Cloud cloud = draw_cloud(8, {10, 8, 9}, 3, {draw.rotation(), draw.in_box(10)}, draw);
    for (Eigen::Vector3d& x : cloud.in_b) x += 0.3 * draw.vector();
    Weights weights = {0, 1, 2, 3, 0, 1, 4, 1};
    Points repeated_a, repeated_b;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      repeated_a.insert(repeated_a.end(), static_cast<std::size_t>(weights[k]), cloud.in_a[k]);
      repeated_b.insert(repeated_b.end(), static_cast<std::size_t>(weights[k]), cloud.in_b[k]);
    }
    const OrientationEstimate expected = method().estimate(repeated_a, repeated_b);
    ASSERT_EQ(expected.status, OrientationStatus::kOk);
    for (const double unit : {1.0, 1e-3, 1e-200, 1e200}) {
      Weights scaled = weights;
      for (double& w : scaled) w *= unit;
      const OrientationEstimate estimate = method().estimate(cloud.in_a, cloud.in_b, scaled);
      ASSERT_EQ(estimate.status, OrientationStatus::kOk) << unit;
      EXPECT_TRUE(is_pose_near(estimate.b_from_a, expected.b_from_a, 1e-11, 1e-10)) << unit;
    }
    // The negative twin: other weights, another pose.
    const OrientationEstimate unweighted = method().estimate(cloud.in_a, cloud.in_b);
    EXPECT_FALSE(is_pose_near(unweighted.b_from_a, expected.b_from_a, 1e-11, 1e-10));
  }
}

TEST_P(MethodTest, LineInFloatFarFromOneOriginIsStillALine) {
  // Rounded at 1e6 the line has a thickness that says nothing.
  Points in_a, in_b;
  const Eigen::Matrix3d rotation = rotation_from_vector({0.3, -0.5, 0.8});
  for (int k = -5; k <= 5; ++k) {
    in_a.push_back(0.37 * k * Eigen::Vector3d(1, 2, -1));
    in_b.push_back(rotation * in_a.back() + Eigen::Vector3d(1e6, 2e6, -1e6));
  }
  EXPECT_NE(method().estimate(in_float(in_a), in_float(in_b)).status, OrientationStatus::kOk);
  in_a[3] += Eigen::Vector3d(100, 0, 0);  // the negative twin: far off the line
  in_b[3] += rotation * Eigen::Vector3d(100, 0, 0);
  in_a[4] += Eigen::Vector3d(0, 0, 100);
  in_b[4] += rotation * Eigen::Vector3d(0, 0, 100);
  const OrientationEstimate estimate = method().estimate(in_float(in_a), in_float(in_b));
  ASSERT_EQ(estimate.status, OrientationStatus::kOk);
  EXPECT_TRUE(is_rotation_near(estimate.b_from_a.rotation, rotation, 0.02));
}

TEST_P(MethodTest, CloudsOfDifferentSizeTurnAlike) {
  Draw draw(41);
  for (const double ratio : {1e-6, 0.01, 2.0, 10.0, 1e6}) {
    const Eigen::Matrix3d rotation = draw.rotation();
    Points in_a, in_b;
    for (int k = 0; k < 10; ++k) {
      in_a.push_back(draw.in_box(10));
      in_b.push_back(ratio * (rotation * in_a.back()) + Eigen::Vector3d(1, 2, 3));
    }
    const OrientationEstimate estimate = method().estimate(in_a, in_b);
    ASSERT_EQ(estimate.status, OrientationStatus::kOk) << ratio;
    EXPECT_TRUE(is_rotation_near(estimate.b_from_a.rotation, rotation, 1e-6)) << ratio;
  }
}

TEST_P(MethodTest, SizesThatNoNumberComparesHaveAStatus) {
  Draw draw(42);
  Points in_a, in_b;
  for (int k = 0; k < 10; ++k) {
    const Eigen::Vector3d x = draw.in_box(1);
    in_a.push_back(1e-170 * x);
    in_b.push_back(1e170 * x);
  }
  const OrientationEstimate estimate = method().estimate(in_a, in_b);
  EXPECT_TRUE(estimate.b_from_a.rotation.allFinite());
  EXPECT_TRUE(estimate.b_from_a.translation.allFinite());
  EXPECT_TRUE(std::isfinite(estimate.scale));
}

TEST_P(MethodTest, PointsInFloatGiveWhatTheyHold) {
  Draw draw(34);
  for (const double offset : {0.0, 1e3, 1e6}) {
    const Pose b_from_a = {draw.rotation(), draw.in_box(100)};
    const Cloud cloud = draw_cloud(50, {10, 10, 10}, offset, b_from_a, draw);
    const FloatPoints a = in_float(cloud.in_a);
    const FloatPoints b = in_float(cloud.in_b);
    const OrientationEstimate estimate = method().estimate(a, b);
    const OrientationEstimate expected = method().estimate(in_double(a), in_double(b));
    ASSERT_EQ(estimate.status, OrientationStatus::kOk);
    // Sums of the same numbers, at most in another order.
    EXPECT_TRUE(is_pose_near(estimate.b_from_a, expected.b_from_a, 1e-12, 1e-12 * (10 + offset)));
    // And no further from the truth than the coordinates' rounding, half an ulp of 2e6 at most.
    EXPECT_TRUE(
        is_rotation_near(estimate.b_from_a.rotation, b_from_a.rotation, 1e-6 + 2e-8 * offset));
  }
}

TEST_P(MethodTest, CollinearAndCoincidentPointsAreFlagged) {
  Draw draw(35);
  for (const double offset : {0.0, 1.0, 1e3, 1e5}) {
    const Pose b_from_a = {draw.rotation(), draw.in_box(100)};
    const Cloud line = draw_cloud(6, {10, 0, 0}, offset, b_from_a, draw);
    EXPECT_EQ(status(line.in_a, line.in_b), OrientationStatus::kDegenerate) << offset;
    const Cloud slanted = draw_cloud(6, {10, 0, 0}, 0, {draw.rotation(), {1, 2, 3}}, draw);
    EXPECT_EQ(status(slanted.in_b, slanted.in_a), OrientationStatus::kDegenerate);
    const Cloud thick = draw_cloud(6, {10, 2, 2}, offset, b_from_a, draw);
    EXPECT_EQ(status(thick.in_a, thick.in_b), OrientationStatus::kOk) << offset;
  }
  for (const double x : {0.0, 1.0, 1e-300}) {
    const Points spot(5, Eigen::Vector3d(x, 2 * x, 3 * x));
    EXPECT_EQ(status(spot, spot), OrientationStatus::kDegenerate);
    const Cloud cloud = draw_cloud(5, {10, 8, 9}, 0, {}, draw);
    EXPECT_EQ(status(cloud.in_a, spot), OrientationStatus::kDegenerate);
    EXPECT_EQ(status(spot, cloud.in_a), OrientationStatus::kDegenerate);
  }
}

TEST_P(MethodTest, CoplanarPointsAreEnoughButForTheDirectWay) {
  Draw draw(36);
  for (const double offset : {0.0, 100.0}) {
    const Pose b_from_a = {draw.rotation(), draw.in_box(100)};
    const Cloud cloud = draw_cloud(6, {10, 5, 0}, offset, b_from_a, draw);
    const OrientationEstimate estimate = method().estimate(cloud.in_a, cloud.in_b);
    if (is("direct_linear")) {
      EXPECT_EQ(estimate.status, OrientationStatus::kDegenerate);
      continue;
    }
    ASSERT_EQ(estimate.status, OrientationStatus::kOk);
    EXPECT_TRUE(is_pose_near(estimate.b_from_a, b_from_a, 1e-12, 1e-10));
  }
}

TEST_P(MethodTest, MirroredPointsGiveARotationOrAStatus) {
  Draw draw(37);
  for (int i = 0; i < 30; ++i) {
    Cloud cloud = draw_cloud(12, {10, 7, 4}, 0, {draw.rotation(), draw.in_box(10)}, draw);
    for (Eigen::Vector3d& x : cloud.in_b) x.x() = -x.x();
    const OrientationEstimate estimate = method().estimate(cloud.in_a, cloud.in_b);
    if (is("arun") || is("direct_linear")) {
      EXPECT_EQ(estimate.status, OrientationStatus::kReflection);
      continue;
    }
    ASSERT_EQ(estimate.status, OrientationStatus::kOk);
    EXPECT_TRUE(is_rotation_near(estimate.b_from_a.rotation, umeyama_pose(cloud).rotation, 1e-10));
  }
}

TEST_P(MethodTest, TooFewOrUnmatchedPointsAreFlagged) {
  const Points four = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Points three(four.begin(), four.begin() + 3);
  const Points two(four.begin(), four.begin() + 2);
  EXPECT_EQ(status({}, {}), OrientationStatus::kTooFewPoints);
  EXPECT_EQ(status(two, two), OrientationStatus::kTooFewPoints);
  EXPECT_EQ(status(four, three), OrientationStatus::kTooFewPoints);
  EXPECT_EQ(status(four, four), OrientationStatus::kOk);
  EXPECT_EQ(status(three, three),
            is("direct_linear") ? OrientationStatus::kTooFewPoints : OrientationStatus::kOk);
  EXPECT_EQ(status(four, four, {1, 0, 1, 0}), OrientationStatus::kTooFewPoints);
  EXPECT_EQ(status(four, four, {0, 0, 0, 0}), OrientationStatus::kTooFewPoints);
}

TEST_P(MethodTest, CoordinatesThatAreNotFiniteAreFlagged) {
  const Points good = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    for (std::size_t k = 0; k < good.size(); ++k) {
      Points broken = good;
      broken[k][static_cast<Eigen::Index>(k % 3)] = bad;
      EXPECT_EQ(status(broken, good), OrientationStatus::kNotFinite);
      EXPECT_EQ(status(good, broken), OrientationStatus::kNotFinite);
      EXPECT_EQ(status(good, broken, {1, 2, 3, 4, 5}), OrientationStatus::kNotFinite);
    }
  }
  EXPECT_EQ(status(good, good), OrientationStatus::kOk);
}

TEST_P(MethodTest, BadWeightsAreFlagged) {
  const Points good = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  EXPECT_EQ(status(good, good, {1, 2, 3, 4, 0}), OrientationStatus::kOk);
  EXPECT_EQ(status(good, good, {1, 2, 3, 4}), OrientationStatus::kBadWeights);
  EXPECT_EQ(status(good, good, {1, 2, 3, 4, 5, 6}), OrientationStatus::kBadWeights);
  for (const double bad : {-1.0, -1e-300, kNaN, kInfinity}) {
    EXPECT_EQ(status(good, good, {1, 2, bad, 4, 5}), OrientationStatus::kBadWeights) << bad;
  }
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

TEST(UmeyamaScaled, FindsTheScale) {
  Draw draw(39);
  const OrientationMethod* method = find_orientation_method("umeyama_scaled");
  for (const double scale : {1e-3, 0.5, 1.0, 7.0, 1e4}) {
    const Pose b_from_a = {draw.rotation(), {1, 2, 3}};
    Cloud cloud = draw_cloud(10, {10, 8, 9}, 5, {b_from_a.rotation, {0, 0, 0}}, draw);
    for (Eigen::Vector3d& x : cloud.in_b) x = scale * x + b_from_a.translation;
    const OrientationEstimate estimate = method->estimate(cloud.in_a, cloud.in_b);
    ASSERT_EQ(estimate.status, OrientationStatus::kOk);
    EXPECT_NEAR(estimate.scale / scale, 1, 1e-13);
    EXPECT_TRUE(is_pose_near(estimate.b_from_a, b_from_a, 1e-12, 1e-12 * (1 + 20 * scale)));
  }
}

TEST(GaussNewton, ConvergesFromSaddlesAndFromTheMinimum) {
  Draw draw(40);
  const OrientationMethod* method = find_orientation_method("gauss_newton");
  const Points box = {{3, 2, 1}, {3, -2, -1}, {-3, 2, -1}, {-3, -2, 1}};  // principal axes x, y, z
  for (int i = 0; i < 200; ++i) {
    // Exactly half a turn about a principal axis, where the gradient at the identity vanishes; or
    // nearly, about any axis.
    const Eigen::Matrix3d rotation =
        i < 3
            ? Eigen::Matrix3d(2 * Eigen::Vector3d::Unit(i) * Eigen::Vector3d::Unit(i).transpose() -
                              Eigen::Matrix3d::Identity())
            : draw.rotation_by(kPi - (i % 4 ? std::pow(10.0, -(i % 16)) : 0.0));
    const Pose b_from_a = {rotation, draw.in_box(10)};
    Points in_b;
    for (const Eigen::Vector3d& x : box) in_b.push_back(b_from_a * x);
    const OrientationEstimate estimate = method->estimate(box, in_b);
    ASSERT_EQ(estimate.status, OrientationStatus::kOk) << i;
    EXPECT_TRUE(is_pose_near(estimate.b_from_a, b_from_a, 1e-12, 1e-12)) << i;
  }
}

TEST(OrientationStatus, HasAName) {
  EXPECT_EQ(to_string(OrientationStatus::kOk), "ok");
  EXPECT_EQ(to_string(OrientationStatus::kReflection), "reflection");
}

}  // namespace
}  // namespace sightline
