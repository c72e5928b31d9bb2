// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/random/random.h"

#include <algorithm>
#include <cmath>
#include <numbers>
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

// Box-Muller with the words of the blocks and the library's functions.
std::vector<double> slow_normals(RandomStream stream, int batches) {
  constexpr int kBlocks = 64;
  std::vector<double> out;
  for (int batch = 0; batch < batches; ++batch) {
    std::vector<double> normals(4 * kBlocks);
    for (int block = 0; block < kBlocks; ++block) {
      for (const int half : {0, 2 * kBlocks}) {
        const double uniform = (std::floor(stream.bits() / 2.0) + 0.5) * 0x1p-31;
        const double radius = std::sqrt(-2 * std::log(uniform));
        const uint32_t word = stream.bits();
        const double low = static_cast<double>(word & 0x3fffffffu);
        const double centred = low < 0x1p29 ? low : low - 0x1p30;
        const double angle = (centred + 0.5) * std::numbers::pi * 0x1p-31;
        const double cosine = std::cos(angle) * ((word & 0x80000000u) != 0 ? -1 : 1);
        const bool is_turned = (word & 0x40000000u) != 0;
        normals[half + block] = radius * (is_turned ? std::sin(angle) : cosine);
        normals[half + kBlocks + block] = radius * (is_turned ? cosine : std::sin(angle));
      }
    }
    out.insert(out.end(), normals.begin(), normals.end());
  }
  return out;
}

TEST(RandomStream, FastNormalsAreThoseOfTheFormula) {
  constexpr int kBatches = 400;
  const std::vector<double> slow = slow_normals(RandomStream(3, "fast", 5), kBatches);
  std::vector<float> fast(slow.size());
  RandomStream(3, "fast", 5).normals(fast);
  for (size_t i = 0; i < fast.size(); ++i) {
    // Next to 1 a uniform number is rounded by up to 2^-25, the radius r by 2^-25 / r, and r >=
    // |x|.
    const double tolerance = std::max(1e-6, std::min(5e-4, 1.2e-7 / std::abs(slow[i])));
    ASSERT_NEAR(fast[i], slow[i], tolerance) << i;
  }
}

TEST(RandomStream, FastNormalsComeInWholeBatches) {
  std::vector<float> whole(700), part(300), rest(400), other(700);
  RandomStream(1, "fast", 0).normals(whole);
  RandomStream stream(1, "fast", 0);
  stream.normals(part);
  stream.normals(rest);
  RandomStream(1, "fast", 1).normals(other);
  EXPECT_TRUE(std::equal(part.begin(), part.end(), whole.begin()));
  EXPECT_EQ(rest[0], whole[512]);  // the second batch of 256 was begun
  EXPECT_NE(other[0], whole[0]);
}

TEST(RandomStream, FastNormalsHaveTheLawOfNormal) {
  constexpr size_t kCount = 1 << 21;
  std::vector<float> x(kCount);
  RandomStream(1, "law", 0).normals(x);
  double moments[7] = {}, neighbours = 0, beyond[6] = {};
  for (size_t i = 0; i < kCount; ++i) {
    double power = 1;
    for (double& moment : moments) {
      moment += power / kCount;
      power *= x[i];
    }
    if (i > 0) neighbours += static_cast<double>(x[i]) * x[i - 1] / kCount;
    for (int k = 3; k <= 5; ++k) beyond[k] += std::abs(x[i]) > k ? 1 : 0;
  }
  // The variance of x^k is E x^2k - (E x^k)^2, with E x^2k = (2k - 1)!!.
  const double five_sigma = 5 / std::sqrt(static_cast<double>(kCount));
  EXPECT_NEAR(moments[1], 0, five_sigma);
  EXPECT_NEAR(moments[2], 1, five_sigma * std::sqrt(2.0));
  EXPECT_NEAR(moments[3], 0, five_sigma * std::sqrt(15.0));
  EXPECT_NEAR(moments[4], 3, five_sigma * std::sqrt(96.0));
  EXPECT_NEAR(moments[5], 0, five_sigma * std::sqrt(945.0));
  EXPECT_NEAR(moments[6], 15, five_sigma * std::sqrt(10395.0 - 225));
  EXPECT_NEAR(neighbours, 0, five_sigma);
  for (int k = 3; k <= 5; ++k) {
    const double expected = kCount * std::erfc(k / std::sqrt(2.0));  // 5662, 133 and 1.2
    EXPECT_NEAR(beyond[k], expected, 5 * std::sqrt(expected)) << k;
  }
  // Kolmogorov and Smirnov: the distance exceeds 2.4 / sqrt(n) once in 50 000 times.
  std::sort(x.begin(), x.end());
  double distance = 0;
  for (size_t i = 0; i < kCount; ++i) {
    const double share = 0.5 * std::erfc(-x[i] / std::sqrt(2.0));
    distance = std::max({distance, share - static_cast<double>(i) / kCount,
                         static_cast<double>(i + 1) / kCount - share});
  }
  EXPECT_LT(distance, 2.4 / std::sqrt(static_cast<double>(kCount)));
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
