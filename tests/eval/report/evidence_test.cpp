// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/evidence.h"

#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/study/study_file.h"
#include "tests/eval/report/small_report.h"
#include "tests/eval/studies.h"

namespace sightline {
namespace {

using namespace small_report;
using ::testing::HasSubstr;
using ::testing::Not;

// The choices as trial numbers, for a solver's story is told by its captions.
std::map<int64_t, std::string> captions(const std::vector<FrameChoice>& choices) {
  std::map<int64_t, std::string> by_trial;
  for (const FrameChoice& choice : choices) by_trial[choice.trial] += choice.caption;
  return by_trial;
}

TEST(Evidence, TakesTheFirstDrawOfEachConditionTheMedianAndTheWorst) {
  const SmallReport report;
  const auto choices = choose_frames(report.study, report.trials);
  ASSERT_EQ(choices.size(), 4u);  // all, as there is room
  EXPECT_EQ(choices[0].trial, 0);
  EXPECT_THAT(choices[0].caption, HasSubstr("pose 1, draw 1; ORPE removes an outlier"));
  EXPECT_EQ(choices[1].trial, 1);
  EXPECT_THAT(choices[1].caption, HasSubstr("pose 2, draw 1; worst pose of ORPE"));
  EXPECT_EQ(choices[2].trial, 3);
  EXPECT_THAT(choices[2].caption, HasSubstr("median of ORPE"));
}

TEST(Evidence, TakesEachKindOfFailureOfEverySolver) {
  SmallReport report;
  report.trials[2].pose_trial().estimates[0].status = EstimateOutcome::kDiverged;
  report.trials[3].pose_trial().estimates[0].false_removals = 1;
  report.trials[3].pose_trial().estimates[1].missed_outliers = 1;
  auto found = captions(choose_frames(report.study, report.trials));
  EXPECT_THAT(found[2], HasSubstr("ORPE finds no pose: diverged"));
  EXPECT_THAT(found[3], HasSubstr("ORPE removes an inlier"));
  EXPECT_THAT(found[3], HasSubstr("LSPE keeps an outlier"));
  EXPECT_THAT(found[0], HasSubstr("a feature is missing: too few edge pixels"));
  EXPECT_THAT(found[0], Not(HasSubstr("finds no pose")));
}

SmallReport random_study(int trials) {
  SmallReport report;
  report.study.conditions.resize(1);
  report.trials.clear();
  for (int i = 0; i < trials; ++i) {
    report.trials.push_back(small_trial(i, trials - i));
    report.trials.back().condition = 0;
  }
  return report;
}

TEST(Evidence, TakesEachTrialOnceUpToItsLimitAndTheSameAgain) {
  const SmallReport report = random_study(100);
  const auto choices = choose_frames(report.study, report.trials);
  EXPECT_EQ(choices.size(), kMostFrames);
  EXPECT_EQ(captions(choices).size(), choices.size());
  EXPECT_EQ(captions(choices), captions(choose_frames(report.study, report.trials)));
  EXPECT_EQ(choices.front().trial, 0);  // the first is the worst as well
  EXPECT_THAT(choices.front().caption, HasSubstr("first draw; worst pose of ORPE"));
  EXPECT_EQ(choices.back().caption, "chosen at random");
  EXPECT_EQ(choose_frames(report.study, report.trials, 5).size(), 5u);
}

TEST(Evidence, OfATrialWithoutAnyPoseIsThatTrial) {
  SmallReport report = random_study(1);
  for (EstimateRecord& estimate : report.trials[0].pose_trial().estimates)
    estimate.status = EstimateOutcome::kTooFewPoints;
  const auto choices = choose_frames(report.study, report.trials);
  ASSERT_EQ(choices.size(), 1u);
  EXPECT_THAT(choices[0].caption, HasSubstr("ORPE finds no pose: too few points"));
  EXPECT_THAT(choices[0].caption, Not(HasSubstr("worst")));
}

TEST(Evidence, SaysWhereTheRunAgainDiffersFromTheStoredTrial) {
  Renderer renderer;
  StudyOverrides overrides;
  overrides.trials = 1;
  const Study study = read_study("boeing-table1", overrides);
  std::vector<TrialRecord> trials = {run_trial(study, 0, renderer).record};
  const std::string differs = "this re-run differs from the stored trial";

  std::vector<FrameEvidence> frames = gather_evidence(study, trials, renderer);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_THAT(frames[0].caption, Not(HasSubstr(differs)));

  double& x_m = trials[0].pose_trial().estimates[0].cam_from_target.translation.x();
  x_m = std::nextafter(x_m, 1e9);
  frames = gather_evidence(study, trials, renderer);
  EXPECT_THAT(frames[0].caption, HasSubstr(differs));
  EXPECT_EQ(frames[0].stored.pose_trial().estimates[0].cam_from_target.translation.x(), x_m);

  trials[0].pose_trial().estimates[0].status = EstimateOutcome::kDegenerate;
  EXPECT_THAT(gather_evidence(study, trials, renderer)[0].caption, HasSubstr(differs));
}

TEST(Evidence, OfNothingIsNothing) {
  EXPECT_TRUE(choose_frames(small_study(), {}).empty());
}

}  // namespace
}  // namespace sightline
