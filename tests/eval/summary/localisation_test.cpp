// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/localisation.h"

#include <cmath>

#include <gtest/gtest.h>

#include "scenes/random/random.h"

namespace sightline {
namespace {

ObservationRecord found(const Eigen::Vector2d& error, bool is_outlier = false) {
  ObservationRecord o;
  o.feature = "corner";
  o.label = is_outlier ? ObservationLabel::kWrongLine : ObservationLabel::kInlier;
  o.is_visible = true;
  o.pixel = error;
  o.error_px = error.norm();
  o.error_sigmas = error.norm() / 0.5;
  o.is_outlier = is_outlier;
  return o;
}

ObservationRecord missing() {
  ObservationRecord o;
  o.feature = "corner";
  o.status = ObservationOutcome::kNoCorner;
  o.label = ObservationLabel::kMissing;
  o.is_visible = true;
  return o;
}

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

TEST(Localisation, SeparatesFoundRateOutliersBiasAndNoise) {
  LocalisationStatistics statistics;
  TrialRecord a, b;
  a.pose_trial().observations = {found({1, 0}), found({3, 0}), missing(), found({20, 0}, true)};
  b.pose_trial().observations = {found({1, 2}), found({3, 2}), missing(), missing()};
  statistics.add(a);
  statistics.add(b);
  const Localisation all = statistics.summary();
  EXPECT_EQ(all.visible, 8);
  EXPECT_EQ(all.found, 5);
  EXPECT_DOUBLE_EQ(all.found_rate.value, 5.0 / 8);
  EXPECT_DOUBLE_EQ(all.outlier_rate.value, 1.0 / 5);
  EXPECT_DOUBLE_EQ(all.bias_u_px.value, 2);
  EXPECT_DOUBLE_EQ(all.bias_v_px.value, 1);
  EXPECT_DOUBLE_EQ(all.rms_px.value, std::sqrt((1 + 9 + 5 + 13) / 8.0));
  EXPECT_DOUBLE_EQ(all.rms_sigmas.value, 2 * all.rms_px.value);
  EXPECT_EQ(all.labels.at(ObservationLabel::kInlier), 4);
  EXPECT_EQ(all.labels.at(ObservationLabel::kMissing), 3);
  EXPECT_EQ(all.labels.at(ObservationLabel::kWrongLine), 1);
  EXPECT_DOUBLE_EQ(all.outlier_px[1], 20);
  EXPECT_DOUBLE_EQ(all.outlier_side[0], 1);
  EXPECT_DOUBLE_EQ(all.outlier_side[1], 0);
}

TEST(Localisation, OfOneFeatureLeavesTheOthersOut) {
  TrialRecord trial;
  trial.pose_trial().observations = {found({1, 0}), found({3, 0})};
  trial.pose_trial().observations[1].feature = "nose";
  const std::string nose = "nose";
  LocalisationStatistics statistics;
  statistics.add(trial, std::span(&nose, 1));
  EXPECT_EQ(statistics.summary().found, 1);
  EXPECT_DOUBLE_EQ(statistics.summary().bias_u_px.value, 3);
}

TEST(Localisation, WhatIsNearIsCountedOfWhatIsToBeSeen) {
  TrialRecord trial;
  trial.pose_trial().observations = {found({1, 0}),        found({0, 2}), found({3.5, 0}),
                                     found({20, 0}, true), missing(),     found({0.5, 0}),
                                     found({30, 0}, true)};
  trial.pose_trial().observations[5].is_visible = trial.pose_trial().observations[6].is_visible =
      false;
  LocalisationStatistics statistics;
  statistics.add(trial);
  const Localisation all = statistics.summary();
  EXPECT_EQ(all.visible, 5);
  EXPECT_DOUBLE_EQ(all.near_rate.value, 2.0 / 5);
  EXPECT_DOUBLE_EQ(all.seen_outlier_rate.value, 1.0 / 4) << "the other is not to be seen";
  EXPECT_DOUBLE_EQ(all.near_median_px, 1.5);
  EXPECT_DOUBLE_EQ(all.near_rms_px, std::sqrt((1 + 4) / 2.0));
  EXPECT_TRUE(std::isnan(LocalisationStatistics().summary().near_median_px));
}

TEST(FeatureCounts, KnowTheTrialWithTheFewest) {
  FeatureCounts counts;
  TrialRecord trial;
  trial.pose_trial().observations.assign(5, found({1, 0}));
  counts.add(trial);
  EXPECT_EQ(counts.few_inliers, 0);
  trial.pose_trial().observations[0] = missing();
  trial.pose_trial().observations[1] = found({20, 0}, true);
  trial.pose_trial().observations.push_back(found({1, 0}));
  trial.pose_trial().observations.back().is_visible = false;
  counts.add(trial);
  EXPECT_EQ(counts.trials, 2);
  EXPECT_EQ(counts.fewest_visible, 5);
  EXPECT_EQ(counts.fewest_inliers, 3);
  EXPECT_EQ(counts.few_inliers, 1);
}

}  // namespace
}  // namespace sightline
