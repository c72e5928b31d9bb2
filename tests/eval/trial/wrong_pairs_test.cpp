// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Orientation studies some of whose pairs are wrong.
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/study/study_file.h"
#include "eval/summary/cells.h"
#include "eval/summary/summary.h"
#include "eval/tables/sweep_table.h"
#include "tests/eval/studies.h"
#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;
using Settings = std::vector<std::string>;

Study wrong_pairs_study(int trials, const Settings& settings) {
  return read_study("orientation-outliers", {.trials = trials, .seed = {}, .set = settings});
}

Summary summary_of(const Study& study) {
  std::vector<TrialRecord> trials;
  for (int64_t i = 0; i < study.trial_count(); ++i) {
    trials.push_back(run_orientation_trial(study, i));
  }
  return summarise(study, trials);
}

const Settings kHalf = {"sweep.points=[40]", "sweep.share=[0.5]"};

Settings half_and(const Settings& more) {
  Settings all = kHalf;
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

TEST(WrongPairs, HaveAConditionForEveryShareAndNumber) {
  const Study study = wrong_pairs_study(1, {});
  ASSERT_EQ(study.conditions.size(), 9u);
  EXPECT_EQ(study.conditions[4].label, "100 points, 50 % wrong");
  EXPECT_EQ(study.conditions[4].values.at("share"), 0.5);
  EXPECT_EQ(study.orientation()->cells[4].outliers, 50);
  EXPECT_EQ(study.orientation()->cells[4].scale, 1);
  EXPECT_TRUE(study.orientation()->has_outliers());
  EXPECT_FALSE(read_study("orientation-points").orientation()->has_outliers());
}

TEST(WrongPairs, SpoilLeastSquaresAndNotConsensus) {
  const Study study = wrong_pairs_study(20, kHalf);
  const Summary summary = summary_of(study);
  const auto mean_of = [&](const char* method) {
    return cell_at(summary, 0, method).geodesic_deg.mean;
  };
  // 20 right pairs of noise 0.2 m in a cube of 20 m: half a degree.
  EXPECT_LT(mean_of("consensus"), 1);
  EXPECT_LT(mean_of("orpe"), 1);
  EXPECT_LT(mean_of("ransac_umeyama"), 2);
  EXPECT_GT(mean_of("umeyama"), 5);
  EXPECT_GT(cell_at(summary, 0, "umeyama").geodesic_deg.capped, 0);
  EXPECT_THAT(sweep_blocks(study, summary), HasSubstr("at the cap"));
  const Study without = wrong_pairs_study(3, {"sweep.points=[40]", "sweep.share=[0.0]"});
  const Summary clean = summary_of(without);
  EXPECT_LT(cell_at(clean, 0, "umeyama").geodesic_deg.mean, 1);
  EXPECT_THAT(sweep_blocks(without, clean), Not(HasSubstr("at the cap")));
}

TEST(WrongPairs, NoiseAndScaleAreToldAsTheFileSays) {
  const Summary told = summary_of(wrong_pairs_study(5, half_and({"solver.sigma=known"})));
  const Summary found = summary_of(wrong_pairs_study(5, kHalf));
  EXPECT_NE(cell_at(told, 0, "ransac_umeyama").geodesic_deg.mean,
            cell_at(found, 0, "ransac_umeyama").geodesic_deg.mean);
  const Summary sought =
      summary_of(wrong_pairs_study(5, half_and({"points.scale=2.5", "solver.scale=free"})));
  EXPECT_LT(cell_at(sought, 0, "consensus").geodesic_deg.mean, 1);
  // The negative twin: at a scale of one no right pairs keep their distances.
  const Summary not_sought = summary_of(wrong_pairs_study(5, half_and({"points.scale=2.5"})));
  EXPECT_GT(cell_at(not_sought, 0, "consensus").geodesic_deg.mean, 5);
}

TEST(WrongPairs, MistakesGetOneClearLine) {
  for (const auto& [setting, reason] :
       std::map<std::string, std::string>{{"methods=['consensos']", "did you mean 'consensus'"},
                                          {"sweep.share=[1]", "to 0.9999"},
                                          {"sweep.share=[-0.1]", "from 0"},
                                          {"sweep.share=[0.9]", "must leave at least three"},
                                          {"points.scale=0", "points.scale"},
                                          {"solver.scale=two", "one"},
                                          {"solver.sigma=guess", "known"}}) {
    const std::string error = error_of([s = setting] { wrong_pairs_study(1, {s}); });
    EXPECT_THAT(error, HasSubstr(reason)) << setting;
    EXPECT_THAT(error, Not(HasSubstr("\n"))) << setting;
  }
}

}  // namespace
}  // namespace sightline
