// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics/clustered_ratio.h"

#include <cmath>

#include <gtest/gtest.h>

#include "scenes/random/random.h"

namespace sightline {
namespace {

TEST(ClusteredRatio, AgreesWithCochransExampleByHand) {
  // y = 1, 2, 3 and x = 2, 2, 4: R = 6/8; residuals y - R x = -0.5, 0.5, 0;
  // variance = 0.5 / 64 * 3/2.
  ClusteredRatio ratio;
  ratio.add(1, 2);
  ratio.add(2, 2);
  ratio.add(3, 4);
  EXPECT_DOUBLE_EQ(ratio.value(), 0.75);
  const double half = 1.959963984540054 * std::sqrt(0.5 / 64 * 1.5);
  EXPECT_NEAR(ratio.measured().ci95[0], 0.75 - half, 1e-12);
  EXPECT_NEAR(ratio.measured().ci95[1], 0.75 + half, 1e-12);
}

TEST(ClusteredRatio, SaysNothingOfNothing) {
  EXPECT_TRUE(std::isnan(ClusteredRatio().value()));
  ClusteredRatio one;
  one.add(1, 2);
  EXPECT_TRUE(std::isnan(one.measured().ci95[0]));
  EXPECT_TRUE(std::isnan(one.rate().ci95[1]));
}

TEST(ClusteredRatio, OfARateThatNeverHappenedIsWilsons) {
  ClusteredRatio ratio;
  for (int i = 0; i < 10; ++i) ratio.add(0, 1);
  EXPECT_DOUBLE_EQ(ratio.rate().ci95[0], 0);
  // Wilson's upper end for 0 of 10 (Brown, Cai and DasGupta 2001): z2 / (n + z2).
  EXPECT_NEAR(ratio.rate().ci95[1], 3.841459 / 13.841459, 1e-6);
}

TEST(ClusteredRatio, CoversTheTruthOfClusteredDraws) {
  // Features of a trial fail together: each trial has its own rate of 0.2 or 0.8. Intervals that
  // took the features for independent would cover far less.
  RandomStream random(1, "clusters", 0);
  int covered = 0;
  constexpr int kRuns = 400;
  for (int run = 0; run < kRuns; ++run) {
    ClusteredRatio ratio;
    for (int trial = 0; trial < 100; ++trial) {
      const double rate = random.uniform() < 0.5 ? 0.2 : 0.8;
      double failures = 0;
      for (int feature = 0; feature < 10; ++feature) failures += random.uniform() < rate;
      ratio.add(failures, 10);
    }
    const auto [low, high] = ratio.rate().ci95;
    covered += low <= 0.5 && 0.5 <= high;
  }
  // 95 % of 400 is 380 with a standard deviation of 4.4.
  EXPECT_GE(covered, 362);
  EXPECT_LE(covered, 398);
}

}  // namespace
}  // namespace sightline
