// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "eval/statistics/rate_interval.h"
#include "eval/summary/summary_json.h"
#include "tests/eval/summary/handmade_trials.h"

namespace sightline {
namespace {

using namespace handmade;

using ::testing::ElementsAre;
using Json = nlohmann::ordered_json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Summary, HasEveryCellInTheStudysOrder) {
  const Summary summary = summarise(two_poses(), handmade_trials());
  std::vector<std::string> cells;
  for (const CellSummary& cell : summary.cells) {
    cells.push_back(fmt::format("{} {}", cell.condition, cell.solver));
  }
  EXPECT_THAT(cells, ElementsAre("0 orpe", "0 lspe", "0 oracle", "1 orpe", "1 lspe", "1 oracle"));
}

TEST(Summary, KeepsFailuresInEveryDenominator) {
  const Summary summary = summarise(two_poses(), handmade_trials());
  const CellSummary& orpe = cell_of(summary, 0, "orpe");
  EXPECT_EQ(orpe.trials, 3);
  EXPECT_EQ(orpe.failures, 1);
  EXPECT_DOUBLE_EQ(orpe.geodesic_deg.mean, (1 + 20 + 2) / 3.0);
  EXPECT_DOUBLE_EQ(orpe.geodesic_deg.rms, std::sqrt((1 + 400 + 4) / 3.0));
  EXPECT_EQ(orpe.geodesic_deg.median, 2);
  EXPECT_EQ(orpe.geodesic_deg.p90, kInfinity);
  EXPECT_EQ(orpe.geodesic_deg.capped, 1);
  EXPECT_DOUBLE_EQ(orpe.theta_error_deg.mean, (0.5 + 20 + 1) / 3.0);
  EXPECT_DOUBLE_EQ(orpe.t_error_percent.mean, (0.25 + 20 + 0.5) / 3.0);
}

TEST(Summary, CapsAnErrorWithoutCallingItAFailure) {
  const Summary summary = summarise(two_poses(), handmade_trials());
  const CellSummary& lspe = cell_of(summary, 0, "lspe");
  EXPECT_EQ(lspe.failures, 0);
  EXPECT_DOUBLE_EQ(lspe.geodesic_deg.mean, (3 + 4 + 20) / 3.0);
  EXPECT_EQ(lspe.geodesic_deg.capped, 1);
  EXPECT_EQ(lspe.theta_error_deg.capped, 0);
}

TEST(Summary, CountsRemovalsOverAllTrials) {
  const Summary summary = summarise(two_poses(), handmade_trials());
  const CellSummary& orpe = cell_of(summary, 0, "orpe");
  EXPECT_DOUBLE_EQ(orpe.false_removals, (0 + 0 + 1) / 3.0);
  EXPECT_DOUBLE_EQ(orpe.missed_outliers, (0 + 1 + 0) / 3.0) << "the failed trial's outlier";
  EXPECT_DOUBLE_EQ(orpe.exact_set_rate, 1 / 3.0);
  const CellSummary& lspe = cell_of(summary, 0, "lspe");
  EXPECT_DOUBLE_EQ(lspe.false_removals, 0);
  EXPECT_DOUBLE_EQ(lspe.missed_outliers, 2 / 3.0);
  EXPECT_DOUBLE_EQ(lspe.exact_set_rate, 1 / 3.0) << "nothing to remove, nothing removed";
}

TEST(Summary, ComparesWithTheOracle) {
  const Summary summary = summarise(two_poses(), handmade_trials());
  EXPECT_DOUBLE_EQ(cell_of(summary, 0, "orpe").ratio_to_oracle, std::sqrt(405.0 / 9));
  EXPECT_DOUBLE_EQ(cell_of(summary, 0, "lspe").ratio_to_oracle, std::sqrt(425.0 / 9));
  EXPECT_DOUBLE_EQ(cell_of(summary, 0, "oracle").ratio_to_oracle, 1);
}

TEST(Summary, HasNoRatioWithoutAnOracle) {
  Study study = two_poses();
  images_of(study).solving.solvers.pop_back();
  std::vector<TrialRecord> trials = handmade_trials();
  for (TrialRecord& trial : trials) trial.pose_trial().estimates.pop_back();
  const Summary summary = summarise(study, trials);
  EXPECT_TRUE(std::isnan(cell_of(summary, 0, "orpe").ratio_to_oracle));
}

TEST(Summary, LeavesTrialsWithoutAnOracleOutOfItsRatio) {
  std::vector<TrialRecord> trials = handmade_trials();
  trials[2].pose_trial().estimates[2] =
      failed("oracle", EstimateOutcome::kTooFewPoints);  // where orpe failed as well
  const Summary summary = summarise(two_poses(), trials);
  EXPECT_DOUBLE_EQ(cell_of(summary, 0, "orpe").ratio_to_oracle, std::sqrt((1 + 4) / (1.0 + 4)));
  EXPECT_DOUBLE_EQ(cell_of(summary, 0, "oracle").ratio_to_oracle, 1);
}

TEST(Summary, CountsWhatTheImagesGave) {
  const Summary summary = summarise(two_poses(), handmade_trials());
  EXPECT_EQ(summary.observations[0].trials, 3);
  EXPECT_DOUBLE_EQ(summary.observations[0].found, 8 / 3.0);
  EXPECT_DOUBLE_EQ(summary.observations[0].outliers, 2 / 3.0);
  ASSERT_EQ(summary.features.size(), 3);
  const FeatureSummary& a = summary.features[0];
  EXPECT_EQ(a.feature, "a");
  EXPECT_EQ(a.visible, 3);
  EXPECT_EQ(a.found, 3);
  EXPECT_EQ(a.outliers, 0);
  EXPECT_DOUBLE_EQ(a.inlier_rms_px, std::sqrt((9 + 25 + 0) / 3.0 / 2));
  EXPECT_EQ(a.median_px, 3);
  const FeatureSummary& b = summary.features[1];
  EXPECT_EQ(b.visible, 2);
  EXPECT_EQ(b.found, 2);
  EXPECT_EQ(b.median_px, 2);
  const FeatureSummary& c = summary.features[2];
  EXPECT_EQ(c.outliers, 2);
  EXPECT_EQ(c.inlier_rms_px, 0);
  EXPECT_EQ(c.median_px, 10);
}

TEST(Summary, OfACellThatNothingCameOfHasNoNumbersButTheCap) {
  const Summary summary = summarise(two_poses(), handmade_trials());
  const CellSummary& orpe = cell_of(summary, 1, "orpe");
  EXPECT_EQ(orpe.trials, 1);
  EXPECT_EQ(orpe.failures, 1);
  EXPECT_EQ(orpe.geodesic_deg.mean, kAngleCapDeg);
  EXPECT_EQ(orpe.t_error_percent.mean, kTranslationCapPercent);
  EXPECT_EQ(orpe.geodesic_deg.median, kInfinity);
  EXPECT_EQ(orpe.missed_outliers, 0);
  EXPECT_EQ(orpe.exact_set_rate, 0);
  EXPECT_TRUE(std::isnan(orpe.ratio_to_bound));
  EXPECT_TRUE(std::isnan(summary.observations[1].inlier_rms_px));
}

TEST(Summary, HasIntervalsOfItsRates) {
  const Summary summary = summarise(two_poses(), handmade_trials());
  const CellSummary& orpe = cell_of(summary, 0, "orpe");
  EXPECT_EQ(orpe.failure_rate_ci95, rate_interval(1, 3));
  EXPECT_EQ(orpe.exact_set_rate_ci95, rate_interval(1, 3));
}

// Yaw is the middle angle: at 61 degrees about y an error of the rotation moves the other two by
// 1 / cos 61 = 2.06 times as much.
TEST(Summary, HasNoIntervalOfAnglesNearGimbalLock) {
  const auto mean_ci95 = [](double yaw_rad) {
    std::vector<TrialRecord> trials = handmade_trials();
    trials[0].true_cam_from_target.rotation = rotation_from_vector({0, yaw_rad, 0});
    return cell_of(summarise(two_poses(), trials), 0, "orpe");
  };
  constexpr double kDegree = std::numbers::pi / 180;
  EXPECT_FALSE(std::isnan(mean_ci95(59 * kDegree).theta_error_deg.mean_ci95[0]));
  EXPECT_TRUE(std::isnan(mean_ci95(-61 * kDegree).theta_error_deg.mean_ci95[0]));
  EXPECT_FALSE(std::isnan(mean_ci95(-61 * kDegree).geodesic_deg.mean_ci95[0]));
}

// Of 20 trials the 6th to the 15th bound the median: ratios of 1 to 20 of an error over the
// oracle's; a failure is beyond all.
TEST(Summary, HasTheMedianOfTheTrialsRatiosToTheOracle) {
  std::vector<TrialRecord> trials(20, handmade_trials()[0]);
  for (size_t i = 0; i < trials.size(); ++i) {
    trials[i].trial = static_cast<int64_t>(2 * i);
    auto& estimates = trials[i].pose_trial().estimates;
    for (EstimateRecord& estimate : estimates) {
      estimate.status = EstimateOutcome::kOk;
      estimate.geodesic_deg =
          estimate.solver == "oracle" ? 0.01 : 0.01 * static_cast<double>(i + 1);
    }
    if (i == 19) estimates[0].status = EstimateOutcome::kDiverged;
  }
  const std::string solver = trials[0].estimates()[0].solver;
  ASSERT_NE(solver, "oracle");
  const Measured median = cell_of(summarise(two_poses(), trials), 0, solver).ratio_to_oracle_median;
  EXPECT_NEAR(median.value, 10.5, 1e-12);
  EXPECT_NEAR(median.ci95[0], 6, 1e-12);
  EXPECT_NEAR(median.ci95[1], 15, 1e-12);
}

TEST(Summary, SaysHowReportedCovariancesFit) {
  std::vector<TrialRecord> trials = handmade_trials();
  for (const size_t i : {0u, 2u, 3u}) {
    trials[i].pose_trial().estimates[1].covariance.emplace().setIdentity();
    trials[i].pose_trial().estimates[1].nees = i == 0   ? 12.5
                                               : i == 2 ? 12.7
                                                        : 5.0;  // the bound is 12.59
  }
  const Summary summary = summarise(two_poses(), trials);
  const NeesSummary& nees = cell_of(summary, 0, "lspe").nees;
  EXPECT_EQ(nees.trials, 3);
  EXPECT_DOUBLE_EQ(nees.mean, (12.5 + 12.7 + 5.0) / 3);
  EXPECT_EQ(nees.median.value, 12.5);
  EXPECT_DOUBLE_EQ(nees.coverage95, 2 / 3.0);
  EXPECT_EQ(nees.coverage95_ci95, rate_interval(2, 3));
  EXPECT_EQ(cell_of(summary, 0, "orpe").nees.trials, 0) << "it reports none";
  const Json json = Json::parse(to_json(two_poses(), summary));
  EXPECT_EQ(json["cells"][1]["nees"]["trials"], 3);
  EXPECT_TRUE(json["cells"][0]["nees"].is_null());
}

TEST(Summary, CountsAMissingEstimateAsAFailure) {
  std::vector<TrialRecord> trials = handmade_trials();
  trials[0].pose_trial().estimates.erase(trials[0].pose_trial().estimates.begin());
  EXPECT_EQ(cell_of(summarise(two_poses(), trials), 0, "orpe").failures, 2);
}

TEST(Summary, DoesNotDependOnTheOrderOfTheTrials) {
  const Study study = two_poses();
  std::vector<TrialRecord> trials = handmade_trials();
  const std::string json = to_json(study, summarise(study, trials));
  std::reverse(trials.begin(), trials.end());
  EXPECT_EQ(to_json(study, summarise(study, trials)), json);
}

TEST(Summary, DependsOnTheSeedInItsIntervalsAlone) {
  std::vector<TrialRecord> trials(30);
  for (int i = 0; i < 30; ++i) {
    trials[i].trial = i;
    trials[i].pose_trial().estimates = {estimate("lspe", 0.1 * i * i)};
  }
  Study study = two_poses();
  const CellSummary before = cell_of(summarise(study, trials), 0, "lspe");
  study.seed = 8;
  const CellSummary after = cell_of(summarise(study, trials), 0, "lspe");
  EXPECT_EQ(before.geodesic_deg.mean, after.geodesic_deg.mean);
  EXPECT_NE(before.geodesic_deg.mean_ci95, after.geodesic_deg.mean_ci95);
}

TEST(Summary, OfNoTrialsIsThereAllTheSame) {
  const Study study = two_poses();
  const Summary summary = summarise(study, std::vector<TrialRecord>{});
  ASSERT_EQ(summary.cells.size(), 6);
  EXPECT_EQ(summary.cells[0].trials, 0);
  EXPECT_NO_THROW(Json::parse(to_json(study, summary)));
}

// A shard may have no trial of a condition: that is no perfect result.
TEST(Summary, OfAConditionWithoutTrialsHasNoNumbers) {
  std::vector<TrialRecord> trials = handmade_trials();
  std::erase_if(trials, [](const TrialRecord& trial) { return trial.condition == 1; });
  const Study study = two_poses();
  const Json json = Json::parse(to_json(study, summarise(study, trials)));
  const Json& cell = json["cells"][3];
  EXPECT_EQ(cell["trials"], 0);
  EXPECT_EQ(cell["failures"], 0);
  for (const char* error : {"theta_error_deg", "t_error_percent", "geodesic_deg"}) {
    EXPECT_TRUE(cell[error]["mean"].is_null());
    EXPECT_TRUE(cell[error]["mean_ci95"][0].is_null());
    EXPECT_TRUE(cell[error]["median"].is_null());
    EXPECT_TRUE(cell[error]["rms"].is_null());
  }
  for (const char* rate : {"false_removals", "missed_outliers", "exact_set_rate", "ratio_to_oracle",
                           "ratio_to_bound"}) {
    EXPECT_TRUE(cell[rate].is_null()) << rate;
  }
  const Json& observations = json["observations"][1];
  EXPECT_EQ(observations["trials"], 0);
  EXPECT_TRUE(observations["found_per_trial"].is_null());
  EXPECT_TRUE(observations["outliers_per_trial"].is_null());
}

}  // namespace
}  // namespace sightline
