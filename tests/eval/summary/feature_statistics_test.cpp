// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/feature_statistics.h"

#include <cmath>
#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "tests/eval/studies.h"
#include "tests/eval/summary/handmade_trials.h"

namespace sightline {
namespace {

using handmade::corner_missing;
using handmade::corner_off_by;

TEST(FeatureCounts, KnowTheTrialWithTheFewest) {
  FeatureCounts counts;
  TrialRecord trial;
  trial.pose_trial().observations.assign(5, corner_off_by({1, 0}));
  counts.add(trial);
  EXPECT_EQ(counts.few_inliers, 0);
  trial.pose_trial().observations[0] = corner_missing();
  trial.pose_trial().observations[1] = corner_off_by({20, 0}, true);
  trial.pose_trial().observations.push_back(corner_off_by({1, 0}));
  trial.pose_trial().observations.back().is_visible = false;
  counts.add(trial);
  EXPECT_EQ(counts.trials, 2);
  EXPECT_EQ(counts.fewest_visible, 5);
  EXPECT_EQ(counts.fewest_inliers, 3);
  EXPECT_EQ(counts.few_inliers, 1);
}

Study two_features() {
  Study study;
  study.conditions = {{"near", {}, {}}, {"far", {}, {}}};
  Target target = *load_target("cube");
  target.features[0].name = "corner";
  target.features[1].name = "nose";
  ImageStudy& images = images_of(study);
  images.target = std::make_shared<Target>(std::move(target));
  images.features = {0, 1};
  images.cells.resize(2);
  images.setups.emplace_back();
  return study;
}

ObservationRecord of_feature(ObservationRecord observation, const char* feature) {
  observation.feature = feature;
  return observation;
}

// One trial near, two far.
FeatureStatistics three_trials() {
  FeatureStatistics statistics(two_features());
  TrialRecord trial;
  trial.pose_trial().observations = {corner_off_by({1, 0}),
                                     of_feature(corner_off_by({3, 0}), "nose")};
  statistics.add(trial);
  trial.condition = 1;
  trial.pose_trial().observations = {corner_missing(),
                                     of_feature(corner_off_by({20, 0}, true), "nose")};
  statistics.add(trial);
  trial.pose_trial().observations = {corner_missing(), of_feature(corner_off_by({5, 0}), "nose"),
                                     of_feature(corner_off_by({2, 0}), "chimney")};
  statistics.add(trial);
  return statistics;
}

TEST(FeatureStatistics, KeepsConditionsAndFeaturesApart) {
  const FeatureStatistics statistics = three_trials();
  EXPECT_EQ(statistics.of(0, "nose").found, 1);
  EXPECT_DOUBLE_EQ(statistics.of(0, "nose").bias_u_px.value, 3);
  EXPECT_EQ(statistics.of(1, "corner").found, 0);
  EXPECT_EQ(statistics.of_feature("nose").found, 3);
  EXPECT_EQ(statistics.of_cell(1).found, 3) << "with the chimney";
  EXPECT_EQ(statistics.counts(1).trials, 2);
  EXPECT_DOUBLE_EQ(statistics.inlier_rms_px(1).at("nose"), 5 / std::sqrt(2.0));
}

TEST(FeatureStatistics, ListsEveryFeatureThatATrialHas) {
  const std::vector<FeatureSummary> all = three_trials().summaries();
  ASSERT_EQ(all.size(), 5);
  EXPECT_EQ(all[2].feature, "corner");
  EXPECT_EQ(all[2].condition, 1);
  EXPECT_EQ(all[2].missing.at("no corner"), 2);
  EXPECT_TRUE(std::isnan(all[2].median_px));
  EXPECT_EQ(all[3].outliers, 1);
  EXPECT_EQ(all[3].median_px, 12.5);
  EXPECT_EQ(all[4].feature, "chimney") << "which the study does not have";
}

TEST(FeatureStatistics, OverAllTrialsIsTheSumOfTheCells) {
  const FeatureStatistics statistics = three_trials();
  const FeatureSummary nose = statistics.over_all_trials("nose");
  EXPECT_EQ(nose.condition, kAllConditions);
  EXPECT_EQ(nose.trials, 3);
  EXPECT_EQ(nose.found, 3);
  EXPECT_EQ(nose.outliers, 1);
  EXPECT_DOUBLE_EQ(nose.inlier_rms_px, std::sqrt((9 + 25) / 2.0 / 2));
  EXPECT_EQ(nose.median_px, 5);
  EXPECT_EQ(statistics.over_all_trials("corner").missing.at("no corner"), 2);
  EXPECT_EQ(statistics.over_all_trials("fin").trials, 0) << "of which nothing is known";
  EXPECT_EQ(statistics.of_feature("fin").found, 0);
}

}  // namespace
}  // namespace sightline
