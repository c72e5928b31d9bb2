// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/random.h"

#include <cmath>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace sightline {
namespace {

constexpr int kSamples = 100000;
// Five standard deviations of a mean of kSamples: a wrong generator fails, a right one does not.
const double kFiveSigma = 5 / std::sqrt(static_cast<double>(kSamples));

TEST(RandomStream, IsTheSameForTheSameKeyOnly) {
  RandomStream a(1, "noise", 7), b(1, "noise", 7), seed(2, "noise", 7), name(1, "prior", 7),
      index(1, "noise", 8);
  for (int i = 0; i < 100; ++i) {
    const uint32_t bits = a.bits();
    EXPECT_EQ(bits, b.bits());
    EXPECT_NE(bits, seed.bits());
    EXPECT_NE(bits, name.bits());
    EXPECT_NE(bits, index.bits());
  }
}

TEST(RandomStream, UniformHasTheMomentsOfUniform) {
  RandomStream stream(1, "uniform", 0);
  double sum = 0, sum2 = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double x = stream.uniform();
    ASSERT_GT(x, 0);
    ASSERT_LT(x, 1);
    sum += x;
    sum2 += x * x;
  }
  EXPECT_NEAR(sum / kSamples, 0.5, kFiveSigma * std::sqrt(1.0 / 12));
  EXPECT_NEAR(sum2 / kSamples, 1.0 / 3, kFiveSigma * std::sqrt(4.0 / 45));
}

TEST(RandomStream, NormalHasTheMomentsOfNormal) {
  RandomStream stream(1, "normal", 0);
  double sum = 0, sum2 = 0, sum4 = 0, neighbours = 0, last = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double x = stream.normal();
    sum += x;
    sum2 += x * x;
    sum4 += x * x * x * x;
    neighbours += x * last;
    last = x;
  }
  EXPECT_NEAR(sum / kSamples, 0, kFiveSigma);
  EXPECT_NEAR(sum2 / kSamples, 1, kFiveSigma * std::sqrt(2.0));
  EXPECT_NEAR(sum4 / kSamples, 3, kFiveSigma * std::sqrt(96.0));
  EXPECT_NEAR(neighbours / kSamples, 0, kFiveSigma);
}

TEST(RandomStream, RotationsAreProperAndUniform) {
  RandomStream stream(1, "rotation", 0);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  double trace2 = 0;
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Matrix3d rotation = stream.rotation();
    ASSERT_NEAR(rotation.determinant(), 1, 1e-12);
    sum += rotation;
    trace2 += rotation.trace() * rotation.trace();
  }
  // Under the uniform (Haar) law every element has mean 0 and variance 1/3, and E trace^2 = 1.
  EXPECT_LT((sum / kSamples).cwiseAbs().maxCoeff(), kFiveSigma * std::sqrt(1.0 / 3) * 1.2);
  EXPECT_NEAR(trace2 / kSamples, 1, kFiveSigma * std::sqrt(2.0));
}

TEST(RandomStream, DirectionsStayInTheConeAndFillIt) {
  RandomStream stream(1, "cone", 0);
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 3).normalized();
  const double angle_rad = 0.7;
  double sum = 0;
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Vector3d direction = stream.direction_near(axis, angle_rad);
    ASSERT_NEAR(direction.norm(), 1, 1e-12);
    const double cosine = direction.dot(axis);
    ASSERT_GE(cosine, std::cos(angle_rad) - 1e-12);
    sum += cosine;
  }
  const double width = 1 - std::cos(angle_rad);  // cosines are uniform over it
  EXPECT_NEAR(sum / kSamples, 1 - width / 2, kFiveSigma * width / std::sqrt(12.0));
}

}  // namespace
}  // namespace sightline
