// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What holds for every method of absolute orientation with outliers.
#include "pose/robust_alignment.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/pose/matchers.h"
#include "tests/pose/orientation/wrong_pairs.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

class RobustAlignmentTest : public testing::TestWithParam<RobustAlignmentMethod> {
 protected:
  RobustAlignment align_by(const WrongPairs& pairs, const RobustAlignmentOptions& options = {},
                           const Weights& weights = {}) const {
    return GetParam().align({pairs.in_a, pairs.in_b, weights}, options);
  }
  bool is(std::string_view name) const { return GetParam().name == name; }
};

INSTANTIATE_TEST_SUITE_P(Orientation, RobustAlignmentTest,
                         testing::ValuesIn(robust_alignment_methods().begin(),
                                           robust_alignment_methods().end()),
                         [](const auto& of) { return std::string(of.param.name); });

/// Neither NaN nor, unless the covariance is not known, infinite.
testing::AssertionResult is_whole(const RobustAlignment& alignment) {
  if (!is_valid(alignment.b_from_a)) return testing::AssertionFailure() << "not a rigid pose";
  const bool is_free_of_nan = !alignment.covariance.hasNaN() && std::isfinite(alignment.scale) &&
                              std::isfinite(alignment.residual_rms_m) &&
                              std::isfinite(alignment.sigma_m);
  if (!is_free_of_nan) return testing::AssertionFailure() << "holds a number that is not finite";
  return testing::AssertionSuccess();
}

TEST_P(RobustAlignmentTest, IsExactOnExactInliers) {
  Draw draw(70);
  for (const int n : {4, 5, 8, 20, 60, 300, 2000}) {
    for (const bool is_known : {true, false}) {
      const int outliers = n < 8 ? 0 : n / 2;
      const WrongPairs pairs =
          draw_wrong_pairs({.pairs = n, .outliers = outliers, .sigma_m = 0}, draw);
      const RobustAlignment alignment = align_by(pairs, {.sigma_m = is_known ? 1e-3 : 0});
      ASSERT_EQ(alignment.status, OrientationStatus::kOk) << n;
      EXPECT_TRUE(is_whole(alignment));
      // The comparator draws a line at a distance, within which an outlier may lie.
      if (is("ransac_umeyama") && !is_known) continue;
      EXPECT_TRUE(is_pose_near(alignment.b_from_a, pairs.b_from_a, 1e-9, 1e-8)) << n;
      EXPECT_EQ(alignment.removed, pairs.outliers) << n;
      EXPECT_LT(alignment.residual_rms_m, 1e-8);
      EXPECT_TRUE(alignment.is_significant);
    }
  }
}

TEST_P(RobustAlignmentTest, SaysWhatItThinksOfEachPair) {
  Draw draw(71);
  const WrongPairs pairs = draw_wrong_pairs({.pairs = 40, .outliers = 20}, draw);
  const RobustAlignment alignment = align_by(pairs, {.sigma_m = pairs.sigma_m});
  ASSERT_EQ(alignment.status, OrientationStatus::kOk);
  ASSERT_EQ(alignment.inlier_probabilities.size(), 40u);
  ASSERT_EQ(alignment.residuals_m.size(), 40u);
  for (std::size_t k = 0; k < 40; ++k) {
    const Eigen::Vector3d x = alignment.b_from_a * pairs.in_a[k];
    EXPECT_NEAR(alignment.residuals_m[k], (x - pairs.in_b[k]).norm(), 1e-10);
    const bool is_removed =
        std::binary_search(alignment.removed.begin(), alignment.removed.end(), static_cast<int>(k));
    EXPECT_EQ(is_removed, !(alignment.inlier_probabilities[k] > 0.5));
  }
  EXPECT_EQ(alignment.removed, pairs.outliers);
  EXPECT_EQ(alignment.sigma_m, pairs.sigma_m);
}

TEST_P(RobustAlignmentTest, TheSameInputGivesTheSameBits) {
  Draw draw(72);
  const WrongPairs pairs = draw_wrong_pairs({.pairs = 100, .outliers = 70}, draw);
  const RobustAlignment one = align_by(pairs);
  const RobustAlignment other = align_by(pairs);
  EXPECT_EQ(one.b_from_a.rotation, other.b_from_a.rotation);
  EXPECT_EQ(one.b_from_a.translation, other.b_from_a.translation);
  EXPECT_EQ(one.inlier_probabilities, other.inlier_probabilities);
}

TEST_P(RobustAlignmentTest, OrderFramesAndUnitsDoNotMatter) {
  Draw draw(73);
  const WrongPairs pairs = draw_wrong_pairs({.pairs = 60, .outliers = 30}, draw);
  const RobustAlignment here = align_by(pairs, {.sigma_m = pairs.sigma_m});
  ASSERT_EQ(here.status, OrientationStatus::kOk);
  for (const double unit : {1e-12, 1e-3, 1e6, 1e100}) {
    const Pose a_from_c = {draw.rotation(), draw.in_box(100)};
    WrongPairs other;
    for (std::size_t i = pairs.in_a.size(); i-- > 0;) {  // backwards
      other.in_a.push_back(unit * (inverse(a_from_c) * pairs.in_a[i]));
      other.in_b.push_back(unit * pairs.in_b[i]);
    }
    const RobustAlignment there = align_by(other, {.sigma_m = unit * pairs.sigma_m});
    ASSERT_EQ(there.status, OrientationStatus::kOk) << unit;
    Pose b_from_c = there.b_from_a;
    b_from_c.translation /= unit;
    // To a small part of the noise: what is far from doubt is weighed alike.
    EXPECT_TRUE(is_pose_near(b_from_c, here.b_from_a * a_from_c, 1e-5, 1e-4)) << unit;
    EXPECT_EQ(there.removed.size(), here.removed.size());
  }
}

TEST_P(RobustAlignmentTest, PairsThatCannotBeUsedAreIgnored) {
  Draw draw(74);
  WrongPairs pairs = draw_wrong_pairs({.pairs = 30, .outliers = 8}, draw);
  const RobustAlignment before = align_by(pairs);
  Weights weights(30, 1.0);
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    pairs.in_a.push_back({bad, 0, 0});
    pairs.in_b.push_back({0, 0, 0});
    pairs.in_a.push_back({0, 0, 0});
    pairs.in_b.push_back({0, bad, 0});
  }
  for (const double bad_weight : {0.0, -1.0, kNaN, kInfinity}) {
    pairs.in_a.push_back({1, 2, 3});
    pairs.in_b.push_back({4, 5, 6});
    weights.resize(pairs.in_a.size(), 1.0);
    weights.back() = bad_weight;
  }
  const RobustAlignment alignment = align_by(pairs, {}, weights);
  ASSERT_EQ(alignment.status, OrientationStatus::kOk);
  EXPECT_EQ(alignment.ignored, (std::vector<int>{30, 31, 32, 33, 34, 35, 36, 37, 38, 39}));
  EXPECT_EQ(alignment.b_from_a.rotation, before.b_from_a.rotation);
  EXPECT_EQ(alignment.removed, before.removed);
  EXPECT_EQ(alignment.inlier_probabilities[32], 0);
  EXPECT_TRUE(std::isnan(alignment.residuals_m[32]));
  EXPECT_TRUE(std::isfinite(alignment.residuals_m[38]));
  EXPECT_TRUE(before.ignored.empty());  // the negative twin
}

TEST_P(RobustAlignmentTest, FarPairsAreOutliersAsAnyOther) {
  Draw draw(75);
  for (const double far : {1e3, 1e6, 1e9, 1e15}) {
    for (const int n : {8, 30}) {
      WrongPairs pairs = draw_wrong_pairs({.pairs = n}, draw);
      pairs.in_a[0] = far * Eigen::Vector3d(1, 1, 0);
      pairs.in_b[1] = far * Eigen::Vector3d(0, 1, -1);
      const RobustAlignment alignment = align_by(pairs, {.sigma_m = pairs.sigma_m});
      ASSERT_EQ(alignment.status, OrientationStatus::kOk) << far;
      EXPECT_EQ(alignment.removed, (std::vector<int>{0, 1})) << far << " " << n;
      EXPECT_TRUE(is_pose_near(alignment.b_from_a, pairs.b_from_a, 0.1, 0.5)) << far;
    }
  }
}

TEST_P(RobustAlignmentTest, ScaleIsFoundWhereItIsSought) {
  Draw draw(76);
  for (const double scale : {1e-6, 0.5, 1.0, 3.0, 1e4}) {
    const WrongPairs pairs = draw_wrong_pairs(
        {.pairs = 40, .outliers = 20, .sigma_m = 0.02 * scale, .scale = scale}, draw);
    const RobustAlignment alignment =
        align_by(pairs, {.sigma_m = pairs.sigma_m, .estimates_scale = true});
    ASSERT_EQ(alignment.status, OrientationStatus::kOk) << scale;
    // 0.02 of 10 m, 20 pairs.
    EXPECT_NEAR(alignment.scale / scale, 1, 5 * alignment.scale_sd / scale);
    EXPECT_LT(alignment.scale_sd / scale, 2e-3);
    EXPECT_GT(alignment.scale_sd, 0);
    EXPECT_EQ(alignment.removed, pairs.outliers) << scale;
    const RobustAlignment rigid = align_by(pairs, {.sigma_m = pairs.sigma_m});
    if (rigid.status == OrientationStatus::kOk) {
      EXPECT_EQ(rigid.scale, 1);
      EXPECT_EQ(rigid.removed == pairs.outliers, scale == 1);
    }
  }
}

TEST_P(RobustAlignmentTest, WeightsAreInverseVariances) {
  Draw draw(77);
  WrongPairs pairs = draw_wrong_pairs({.pairs = 30, .sigma_m = 0}, draw);
  Weights weights;
  for (Eigen::Vector3d& x : pairs.in_b) {
    weights.push_back(draw.uniform(0.2, 5));
    x += 0.05 / std::sqrt(weights.back()) * draw.vector();
  }
  const Alignment expected =
      align<double>(*find_orientation_method("fast"), pairs.in_a, pairs.in_b, weights, 0.05);
  for (const double unit : {1.0, 1e-6, 1e6}) {
    Weights scaled = weights;
    for (double& w : scaled) w *= unit;
    const RobustAlignment alignment = align_by(pairs, {.sigma_m = 0.05 * std::sqrt(unit)}, scaled);
    ASSERT_EQ(alignment.status, OrientationStatus::kOk);
    EXPECT_TRUE(alignment.removed.empty());
    // No pair is in doubt by more than a percent.
    EXPECT_TRUE(is_pose_near(alignment.b_from_a, expected.b_from_a, 1e-3, 5e-3));
    EXPECT_NEAR(alignment.covariance(0, 0), expected.covariance(0, 0),
                0.05 * expected.covariance(0, 0));
  }
}

TEST_P(RobustAlignmentTest, WhatDoesNotDetermineAPoseHasAStatus) {
  const Points four = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Points three(four.begin(), four.begin() + 3);
  const Points two(four.begin(), four.begin() + 2);
  const auto status = [](const Points& a, const Points& b, const Weights& weights = {},
                         const RobustAlignmentOptions& options = {}) {
    const RobustAlignment alignment = GetParam().align({a, b, weights}, options);
    EXPECT_TRUE(is_whole(alignment));
    return alignment.status;
  };
  EXPECT_EQ(status({}, {}), OrientationStatus::kTooFewPoints);
  EXPECT_EQ(status(two, two), OrientationStatus::kTooFewPoints);
  EXPECT_EQ(status(four, three), OrientationStatus::kTooFewPoints);
  EXPECT_EQ(status(three, three), OrientationStatus::kOk);
  EXPECT_EQ(status(four, four), OrientationStatus::kOk);
  EXPECT_EQ(status(four, four, {1, 1, 1}), OrientationStatus::kBadWeights);
  EXPECT_EQ(status(four, four, {1, 0, 1, kNaN}), OrientationStatus::kTooFewPoints);
  EXPECT_EQ(status(four, four, {}, {.sigma_m = -1}), OrientationStatus::kNotFinite);
  EXPECT_EQ(status(four, four, {}, {.sigma_m = kNaN}), OrientationStatus::kNotFinite);
  const Points spot(6, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(status(spot, spot), OrientationStatus::kDegenerate);
  Points line;
  for (int i = 0; i < 8; ++i) line.push_back(i * Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(status(line, line), OrientationStatus::kDegenerate);
  line[3] += Eigen::Vector3d(5, 0, 0);  // the negative twin
  line[5] += Eigen::Vector3d(0, 0, 7);
  EXPECT_EQ(status(line, line), OrientationStatus::kOk);
}

TEST_P(RobustAlignmentTest, PlanesAreEnough) {
  Draw draw(78);
  WrongPairs pairs = draw_wrong_pairs({.pairs = 30, .outliers = 10, .sigma_m = 0}, draw);
  for (std::size_t k = 0; k < 30; ++k) {
    pairs.in_a[k].z() = 0;
    if (k < pairs.inliers()) pairs.in_b[k] = pairs.b_from_a * pairs.in_a[k];
  }
  const RobustAlignment alignment = align_by(pairs, {.sigma_m = 0.01});
  ASSERT_EQ(alignment.status, OrientationStatus::kOk);
  EXPECT_TRUE(is_pose_near(alignment.b_from_a, pairs.b_from_a, 1e-9, 1e-8));
}

TEST_P(RobustAlignmentTest, ClutterIsNotSignificant) {
  Draw draw(79);
  int significant = 0;
  constexpr int kDraws = 200;
  for (int i = 0; i < kDraws; ++i) {
    const WrongPairs pairs = draw_wrong_pairs({.pairs = 30, .outliers = 30}, draw);
    significant += align_by(pairs, {.sigma_m = i % 2 ? 0.1 : 0.0}).is_significant;
  }
  // Odds of 100 are asked for: two are expected, and seven or more come once in 200 cases.
  EXPECT_LE(significant, 6);
  int found = 0;  // the negative twin
  for (int i = 0; i < 20; ++i) {
    const WrongPairs pairs = draw_wrong_pairs({.pairs = 30, .outliers = 15}, draw);
    found += align_by(pairs, {.sigma_m = i % 2 ? 0.1 : 0.0}).is_significant;
  }
  EXPECT_EQ(found, 20);
}

TEST(RobustAlignment, OfThreePairsIsTheirLeastSquares) {
  const Points in_a = {{0, 0, 0}, {5, 0, 0}, {0, 4, 0}};
  const Points in_b = {{0, 0, 0.1}, {5.1, 0, 0}, {0, 4, 0}};
  const RobustAlignment alignment = align_with_outliers({in_a, in_b});
  const OrientationEstimate expected = fast_absolute_orientation(in_a, in_b);
  ASSERT_EQ(alignment.status, OrientationStatus::kOk);
  EXPECT_TRUE(is_pose_near(alignment.b_from_a, expected.b_from_a, 1e-12, 1e-12));
  EXPECT_FALSE(alignment.is_significant);
  EXPECT_TRUE(alignment.removed.empty());
}

TEST(RobustAlignment, FloatsAreTakenToDouble) {
  Draw draw(80);
  const WrongPairs pairs = draw_wrong_pairs({.pairs = 40, .outliers = 20}, draw);
  const FloatPoints a = in_float(pairs.in_a);
  const FloatPoints b = in_float(pairs.in_b);
  const Points a_again = in_double(a);
  const Points b_again = in_double(b);
  const RobustAlignment in_floats = align_with_outliers(a, b, {}, {.sigma_m = 0.1});
  const RobustAlignment in_doubles = align_with_outliers({a_again, b_again}, {.sigma_m = 0.1});
  EXPECT_EQ(in_floats.b_from_a.rotation, in_doubles.b_from_a.rotation);
  EXPECT_EQ(in_floats.removed, pairs.outliers);
}

TEST(RobustAlignment, DuplicatesOfAWrongPairAreNoConsensus) {
  Draw draw(81);
  WrongPairs pairs = draw_wrong_pairs({.pairs = 40, .outliers = 30}, draw);
  for (std::size_t k = 11; k < 40; ++k) {
    pairs.in_a[k] = pairs.in_a[10];
    pairs.in_b[k] = pairs.in_b[10];
  }
  const RobustAlignment alignment = align_with_outliers(pairs.points(), {.sigma_m = 0.1});
  ASSERT_EQ(alignment.status, OrientationStatus::kOk);
  EXPECT_EQ(alignment.removed, pairs.outliers);
}

}  // namespace
}  // namespace sightline
