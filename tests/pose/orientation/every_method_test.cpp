// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What holds for every method of the catalogue of absolute orientation.
#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "pose/absolute_orientation.h"
#include "pose/robust_alignment.h"
#include "tests/pose/matchers.h"
#include "tests/pose/orientation/clouds.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

/// A method that takes more than one file has its name before the others' too: consensus_pairs.cpp.
bool is_part_of_a_robust_method(const std::string& stem) {
  for (const RobustAlignmentMethod& method : robust_alignment_methods()) {
    if (stem.starts_with(std::string(method.name) + "_")) return true;
  }
  return false;
}

TEST(OrientationMethods, EqualTheFolder) {
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "pose/orientation")) {
    const std::string stem = entry.path().stem();
    const bool is_method = entry.path().extension() == ".cpp" && !is_part_of_a_robust_method(stem);
    if (is_method) files.insert(stem);
  }
  std::set<std::string> names;
  for (const OrientationMethod& method : orientation_methods()) {
    EXPECT_TRUE(names.emplace(method.name).second) << method.name;
    EXPECT_EQ(find_orientation_method(method.name), &method);
    EXPECT_FALSE(method.summary.empty());
  }
  for (const RobustAlignmentMethod& method : robust_alignment_methods()) {
    EXPECT_TRUE(names.emplace(method.name).second) << method.name;
    EXPECT_EQ(find_robust_alignment_method(method.name), &method);
    EXPECT_FALSE(method.summary.empty());
  }
  EXPECT_EQ(names, files);
  EXPECT_EQ(find_orientation_method("slow"), nullptr);
  EXPECT_EQ(find_robust_alignment_method("slow"), nullptr);
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

TEST(OrientationMethods, AnyUnitOfLengthWillDo) {
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

TEST(OrientationStatus, HasAName) {
  EXPECT_EQ(to_string(OrientationStatus::kOk), "ok");
  EXPECT_EQ(to_string(OrientationStatus::kReflection), "reflection");
}

}  // namespace
}  // namespace sightline
