// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/report/figures.h"
#include "tests/eval/studies.h"

namespace sightline {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// Twenty poses of one solver, each worse than the one before; the worst two are above the 90 %
// quantile.
struct TwentyPoses {
  TwentyPoses() {
    images_of(study).solving.solvers = {built_in(*find_pose_solver("orpe_weighed"))};
    study.conditions.resize(1);
    for (int i = 0; i < 20; ++i) {
      TrialRecord& trial = trials.emplace_back();
      trial.trial = i;
      EstimateRecord& estimate = trial.pose_trial().estimates.emplace_back();
      estimate.solver = "orpe_weighed";
      estimate.geodesic_deg = 0.1 * (i + 1);
    }
  }
  EstimateRecord& estimate(int trial) {
    return trials[static_cast<size_t>(trial)].pose_trial().estimates[0];
  }
  std::string figure() const { return diagnosis_figure({study, summary, trials, {}, {}}); }

  Study study;
  Summary summary;
  std::vector<TrialRecord> trials;
};

TEST(DiagnosisFigure, CountsHowOftenThoseWithADoubtAreWrong) {
  TwentyPoses poses;
  for (int i = 0; i < 20; ++i) poses.estimate(i).is_ambiguous = i >= 16;
  poses.estimate(0).false_removals = 1;
  const std::string html = poses.figure();
  EXPECT_THAT(html, HasSubstr("another pose fits nearly as well"));
  EXPECT_THAT(html, HasSubstr("<td>20</td>\n<td>4 (20.0 %)</td>"));
  EXPECT_THAT(html, HasSubstr("<td>2 (50.0 %)</td><td>1 (6.2 %)</td>"));
  EXPECT_THAT(html, Not(HasSubstr("no more points could be removed")));
  EXPECT_THAT(html, Not(HasSubstr("exactly the outliers removed")));
}

TEST(DiagnosisFigure, HoldsStatedProbabilitiesAgainstHowOftenTheSetIsRight) {
  TwentyPoses poses;
  for (int i = 0; i < 20; ++i) {
    poses.estimate(i).is_ambiguous = false;
    poses.estimate(i).removed_probability = i < 4 ? 0.75 : 1;
  }
  poses.estimate(0).missed_outliers = 1;
  const std::string html = poses.figure();
  EXPECT_THAT(html, HasSubstr("<td>50 to 90</td><td>4</td><td>75.0 %</td>\n<td>3 (75.0 %)</td>"));
  EXPECT_THAT(html, HasSubstr("<td>99 to 100</td><td>16</td><td>100.0 %</td>"));
  EXPECT_THAT(html, Not(HasSubstr("0 to 50")));
}

TEST(DiagnosisFigure, IsNotThereWhereNoSolverSaysAnything) {
  EXPECT_THAT(TwentyPoses().figure(), IsEmpty());
  TwentyPoses failed;  // what a failed solver says counts for nothing
  for (int i = 0; i < 20; ++i) {
    failed.estimate(i).is_ambiguous = true;
    failed.estimate(i).status = EstimateOutcome::kDiverged;
  }
  EXPECT_THAT(failed.figure(), IsEmpty());
}

}  // namespace
}  // namespace sightline
