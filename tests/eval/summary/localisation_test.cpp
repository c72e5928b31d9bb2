// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/localisation.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/eval/summary/handmade_trials.h"

namespace sightline {
namespace {

using handmade::corner_missing;
using handmade::corner_off_by;

TEST(Localisation, SeparatesFoundRateOutliersBiasAndNoise) {
  LocalisationStatistics statistics;
  TrialRecord a, b;
  a.pose_trial().observations = {corner_off_by({1, 0}), corner_off_by({3, 0}), corner_missing(),
                                 corner_off_by({20, 0}, true)};
  b.pose_trial().observations = {corner_off_by({1, 2}), corner_off_by({3, 2}), corner_missing(),
                                 corner_missing()};
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

TEST(Localisation, CountsATrialWithoutObservationsAmongTheTrials) {
  LocalisationStatistics one, two;
  one.add(corner_off_by({1, 0}));
  one.end_trial();
  two.add(corner_off_by({1, 0}));
  two.end_trial();
  two.end_trial();
  EXPECT_TRUE(std::isnan(one.summary().found_rate.ci95[0])) << "one trial says nothing of others";
  EXPECT_FALSE(std::isnan(two.summary().found_rate.ci95[0]));
}

TEST(Localisation, WhatIsNearIsCountedOfWhatIsToBeSeen) {
  TrialRecord trial;
  trial.pose_trial().observations = {
      corner_off_by({1, 0}),        corner_off_by({0, 2}), corner_off_by({3.5, 0}),
      corner_off_by({20, 0}, true), corner_missing(),      corner_off_by({0.5, 0}),
      corner_off_by({30, 0}, true)};
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

}  // namespace
}  // namespace sightline
