// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Residuals, noise and covariance of the methods of the catalogue.
#include "pose/alignment.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/pose/matchers.h"
#include "tests/pose/orientation/clouds.h"
#include "tests/pose/orientation/wrong_pairs.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

class AlignmentTest : public testing::TestWithParam<OrientationMethod> {
 protected:
  Alignment align_by(const Points& a, const Points& b, const Weights& weights = {},
                     double sigma_m = 0) const {
    return align<double>(GetParam(), a, b, weights, sigma_m);
  }
};

INSTANTIATE_TEST_SUITE_P(Orientation, AlignmentTest,
                         testing::ValuesIn(orientation_methods().begin(),
                                           orientation_methods().end()),
                         [](const auto& of) { return std::string(of.param.name); });

TEST_P(AlignmentTest, ResidualsAreWhatThePoseLeaves) {
  Draw draw(60);
  const WrongPairs pairs = draw_wrong_pairs({.pairs = 12, .sigma_m = 0.3}, draw);
  const Weights weights = {1, 2, 0, 1, 0.5, 1, 1, 3, 1, 1, 1, 1};
  const Alignment alignment = align_by(pairs.in_a, pairs.in_b, weights);
  ASSERT_EQ(alignment.status, OrientationStatus::kOk);
  const OrientationEstimate estimate = GetParam().estimate(pairs.in_a, pairs.in_b, weights);
  EXPECT_EQ(alignment.b_from_a.rotation, estimate.b_from_a.rotation);
  EXPECT_EQ(alignment.scale, estimate.scale);
  ASSERT_EQ(alignment.residuals_m.size(), 12u);
  double squares = 0;
  double sum = 0;
  for (std::size_t k = 0; k < 12; ++k) {
    const double residual = (estimate.scale * (estimate.b_from_a.rotation * pairs.in_a[k]) +
                             estimate.b_from_a.translation - pairs.in_b[k])
                                .norm();
    EXPECT_NEAR(alignment.residuals_m[k], residual, 1e-12 * 100);
    squares += weights[k] * residual * residual;
    sum += weights[k];
  }
  EXPECT_NEAR(alignment.residual_rms_m, std::sqrt(squares / sum), 1e-12 * 100);
}

// NEES has the mean 6 and the standard deviation sqrt(12) for a true covariance.
TEST_P(AlignmentTest, CovarianceIsThatOfTheErrors) {
  Draw draw(61);
  constexpr int kDraws = 3000;
  double known = 0;
  double unknown = 0;
  double variance = 0;
  for (int i = 0; i < kDraws; ++i) {
    // Long, wide and flat, so that a covariance without directions would not do.
    Cloud cloud = draw_cloud(12, {10, 5, 2}, 20, {draw.rotation(), draw.in_box(10)}, draw);
    Weights weights;
    for (Eigen::Vector3d& x : cloud.in_b) {
      weights.push_back(draw.uniform(0.3, 3));
      x += 0.02 / std::sqrt(weights.back()) * draw.vector();
    }
    const Alignment told = align_by(cloud.in_a, cloud.in_b, weights, 0.02);
    const Alignment found = align_by(cloud.in_a, cloud.in_b, weights);
    known += squared_error(told.b_from_a, cloud.b_from_a, told.covariance) / kDraws;
    unknown += squared_error(found.b_from_a, cloud.b_from_a, found.covariance) / kDraws;
    variance += found.sigma_m * found.sigma_m / kDraws;
    EXPECT_EQ(told.sigma_m, 0.02);
  }
  const double tolerance = 5 * std::sqrt(12.0 / kDraws);
  EXPECT_NEAR(known, 6, tolerance);
  EXPECT_NEAR(unknown, 6, 1.5 * tolerance);  // Student's law has longer tails
  // A chi-square of 30 degrees over 30 deviates by 0.26; that of the affine way by somewhat more.
  EXPECT_NEAR(variance / (0.02 * 0.02), 1, 5 * 0.4 / std::sqrt(kDraws));
}

TEST_P(AlignmentTest, AnyUnitAndOriginWillDo) {
  Draw draw(62);
  const WrongPairs pairs = draw_wrong_pairs({.pairs = 10, .sigma_m = 0.1}, draw);
  const Alignment here = align_by(pairs.in_a, pairs.in_b);
  for (const double unit : {1e-150, 1e-9, 1e9, 1e150}) {
    Points in_a, in_b;
    for (const Eigen::Vector3d& x : pairs.in_a) in_a.push_back(unit * x);
    for (const Eigen::Vector3d& x : pairs.in_b) in_b.push_back(unit * x);
    const Alignment there = align_by(in_a, in_b);
    ASSERT_EQ(there.status, OrientationStatus::kOk) << unit;
    EXPECT_NEAR(there.sigma_m / unit, here.sigma_m, 1e-9 * here.sigma_m);
    const Eigen::Matrix3d turning = here.covariance.topLeftCorner<3, 3>();
    EXPECT_TRUE(is_matrix_near(Eigen::Matrix3d(there.covariance.topLeftCorner<3, 3>()), turning,
                               1e-9 * turning.norm()));
  }
  Points far_a = pairs.in_a;
  for (Eigen::Vector3d& x : far_a) x += Eigen::Vector3d(1e6, -1e6, 2e6);
  const Alignment far = align_by(far_a, pairs.in_b);
  EXPECT_NEAR(far.residual_rms_m, here.residual_rms_m, 1e-6 * here.residual_rms_m);
  // The same rotation error has a lever of millions of metres.
  EXPECT_GT(far.covariance(3, 3), 1e8 * here.covariance(3, 3));
}

TEST_P(AlignmentTest, PointsWithoutWeightMayHoldAnything) {
  Draw draw(63);
  WrongPairs pairs = draw_wrong_pairs({.pairs = 8, .sigma_m = 0.1}, draw);
  Weights weights(8, 1.0);
  weights[0] = weights[5] = 0;
  const Points fewer_a = {pairs.in_a[1], pairs.in_a[2], pairs.in_a[3],
                          pairs.in_a[4], pairs.in_a[6], pairs.in_a[7]};
  const Points fewer_b = {pairs.in_b[1], pairs.in_b[2], pairs.in_b[3],
                          pairs.in_b[4], pairs.in_b[6], pairs.in_b[7]};
  pairs.in_a[0].y() = kNaN;
  pairs.in_b[5].x() = kInfinity;
  const Alignment alignment = align_by(pairs.in_a, pairs.in_b, weights);
  const Alignment expected = align_by(fewer_a, fewer_b);
  ASSERT_EQ(alignment.status, OrientationStatus::kOk);
  EXPECT_TRUE(is_pose_near(alignment.b_from_a, expected.b_from_a, 1e-12, 1e-10));
  EXPECT_TRUE(std::isnan(alignment.residuals_m[0]) && std::isnan(alignment.residuals_m[5]));
  EXPECT_NEAR(alignment.sigma_m, expected.sigma_m, 1e-9);
  EXPECT_TRUE(
      is_matrix_near(alignment.covariance, expected.covariance, 1e-9 * expected.covariance.norm()));
  weights[0] = 1e-3;  // the negative twin: it counts
  EXPECT_EQ(align_by(pairs.in_a, pairs.in_b, weights).status, OrientationStatus::kNotFinite);
}

TEST_P(AlignmentTest, CloudsOfAnyRatioTurnAlike) {
  Draw draw(64);
  for (const double ratio : {1e-20, 1e-16, 1e-8, 1e8, 1e16, 1e20}) {
    Cloud cloud = draw_cloud(10, {10, 8, 9}, 0, {draw.rotation(), {1, 2, 3}}, draw);
    for (Eigen::Vector3d& x : cloud.in_b) x *= ratio;
    const OrientationEstimate estimate = GetParam().estimate(cloud.in_a, cloud.in_b);
    ASSERT_EQ(estimate.status, OrientationStatus::kOk) << ratio;
    EXPECT_TRUE(is_rotation_near(estimate.b_from_a.rotation, cloud.b_from_a.rotation, 1e-12))
        << ratio;
  }
}

TEST_P(AlignmentTest, FailsAsTheMethodDoes) {
  const Points two = {{0, 0, 0}, {1, 0, 0}};
  const Alignment failed = align_by(two, two);
  EXPECT_EQ(failed.status, OrientationStatus::kTooFewPoints);
  EXPECT_TRUE(failed.residuals_m.empty());
}

TEST(Alignment, FloatIsAsGoodAsItsDigits) {
  Draw draw(65);
  const WrongPairs pairs = draw_wrong_pairs({.pairs = 10, .sigma_m = 0.1}, draw);
  const FloatPoints a = in_float(pairs.in_a);
  const FloatPoints b = in_float(pairs.in_b);
  const OrientationMethod& fast = *find_orientation_method("fast");
  const Alignment in_floats = align<float>(fast, a, b);
  const Alignment in_doubles = align<double>(fast, pairs.in_a, pairs.in_b);
  // Coordinates of 100 m are rounded to 4 micrometres.
  EXPECT_NEAR(in_floats.residual_rms_m, in_doubles.residual_rms_m, 1e-5);
  EXPECT_NEAR(in_floats.sigma_m, in_doubles.sigma_m, 1e-5);
}

// The affine way errs more than least squares: its own covariance says so, that of least squares
// would not.
TEST(Alignment, TheAffineWayHasACovarianceOfItsOwn) {
  Draw draw(66);
  double nees = 0;
  for (int i = 0; i < 500; ++i) {
    Cloud cloud = draw_cloud(8, {10, 5, 2}, 0, {draw.rotation(), {1, 2, 3}}, draw);
    for (Eigen::Vector3d& x : cloud.in_b) x += 0.02 * draw.vector();
    const OrientationEstimate estimate =
        find_orientation_method("direct_linear")->estimate(cloud.in_a, cloud.in_b);
    const Alignment as_least_squares = residuals_and_covariance(
        estimate, OrientationFit::kRigid, std::span<const Eigen::Vector3d>(cloud.in_a),
        std::span<const Eigen::Vector3d>(cloud.in_b), {}, 0.02);
    nees += squared_error(estimate.b_from_a, cloud.b_from_a, as_least_squares.covariance) / 500;
  }
  EXPECT_GT(nees, 8);
}

TEST(Alignment, ThreePairsHaveACovarianceAndTwoDegreesHaveNone) {
  const Points in_a = {{0, 0, 0}, {5, 0, 0}, {0, 4, 0}};
  const Points in_b = {{0, 0, 0.1}, {5.1, 0, 0}, {0, 4, 0}};
  const Alignment rigid = align<double>(*find_orientation_method("fast"), in_a, in_b);
  EXPECT_TRUE(rigid.covariance.allFinite());  // three degrees of freedom are left
  const OrientationMethod& scaled = *find_orientation_method("umeyama_scaled");
  EXPECT_EQ(align<double>(scaled, in_a, in_b).covariance(0, 0), kInfinity);  // and here two
  EXPECT_TRUE(align<double>(scaled, in_a, in_b, {}, 0.1).covariance.allFinite());
}

}  // namespace
}  // namespace sightline
