// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/summary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "eval/results/results_csv.h"
#include "eval/summary/summary_json.h"
#include "pose/bounds.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

using ::testing::ElementsAre;
using Json = nlohmann::ordered_json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string to_csv(const Study& study, const std::vector<TrialRecord>& trials) {
  std::ostringstream text;
  write_csv(study, in_order(trials), text);
  return text.str();
}

Study two_poses() {
  Study study;
  study.name = "tiny";
  study.seed = 7;
  study.draws = 3;
  study.conditions = {{"pose 1", {{"pose", 1}, {"noise_px", 0.5}}, {}},
                      {"pose 2", {{"pose", 2}, {"noise_px", 2.0}}, {}}};
  for (const char* name : {"orpe", "lspe", "oracle"}) {
    study.solvers.push_back(find_pose_solver(name));
  }
  return study;
}

ObservationRecord found(const char* feature, double error_px, bool is_outlier = false) {
  ObservationRecord observation;
  observation.feature = feature;
  observation.is_visible = true;
  observation.error_px = error_px;
  observation.is_outlier = is_outlier;
  return observation;
}

ObservationRecord hidden(const char* feature) {
  ObservationRecord observation;
  observation.feature = feature;
  observation.status = ObservationOutcome::kHidden;
  return observation;
}

EstimateRecord estimate(const char* solver, double geodesic_deg, int false_removals = 0,
                        int missed_outliers = 0) {
  EstimateRecord record;
  record.solver = solver;
  record.geodesic_deg = geodesic_deg;
  record.theta_error_deg = geodesic_deg / 2;
  record.t_error_percent = geodesic_deg / 4;
  record.false_removals = false_removals;
  record.missed_outliers = missed_outliers;
  return record;
}

// With numbers, which must not count.
EstimateRecord failed(const char* solver, EstimateOutcome reason) {
  EstimateRecord record = estimate(solver, 0.25, 7, 9);
  record.status = reason;
  record.removed = {"nonsense"};
  return record;
}

// Three trials of pose 1, small enough to work out by hand; one of pose 2, which nothing came of.
std::vector<TrialRecord> handmade_trials() {
  TrialRecord first;
  first.trial = 0;
  first.pose_trial().observations = {found("a", 3), found("b", 4), found("c", 10, true)};
  first.pose_trial().estimates = {estimate("orpe", 1), estimate("lspe", 3, 0, 1),
                                  estimate("oracle", 1)};
  first.pose_trial().estimates[0].removed = {"c"};

  TrialRecord second;
  second.trial = 2;
  second.pose_trial().observations = {found("a", 5), hidden("b"), found("c", 20, true)};
  second.pose_trial().estimates = {failed("orpe", EstimateOutcome::kDegenerate),
                                   estimate("lspe", 4, 0, 1), estimate("oracle", 2)};

  TrialRecord third;
  third.trial = 4;
  third.pose_trial().observations = {found("a", 0), found("b", 0), found("c", 0)};
  third.pose_trial().estimates = {estimate("orpe", 2, 1, 0), estimate("lspe", 30),
                                  estimate("oracle", 2)};
  third.pose_trial().estimates[0].removed = {"a", "b"};

  TrialRecord dark;
  dark.trial = 1;
  dark.condition = 1;
  dark.pose_trial().estimates = {failed("orpe", EstimateOutcome::kNotImaged),
                                 failed("lspe", EstimateOutcome::kNotImaged),
                                 failed("oracle", EstimateOutcome::kNotImaged)};
  return {first, dark, second, third};
}

const CellSummary& cell_of(const Summary& summary, int condition, const std::string& solver) {
  return *std::find_if(summary.cells.begin(), summary.cells.end(), [&](const CellSummary& c) {
    return c.condition == condition && c.solver == solver;
  });
}

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
  study.solvers.pop_back();
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

// Two trials of the cube from 60 m: six vertices found with these errors, a seventh is an outlier.
std::vector<TrialRecord> cube_trials(double first_error_px, double other_error_px) {
  std::vector<TrialRecord> trials(2);
  for (int i = 0; i < 2; ++i) {
    trials[i].trial = i;
    trials[i].true_cam_from_target = {rotation_from_vector({0.3, -0.4, 0.5}), {0.5, 0.2, 60}};
    for (int k = 0; k < 7; ++k) {
      const double error_px = k == 0 ? first_error_px : other_error_px;
      trials[i].pose_trial().observations.push_back(
          found(fmt::format("vertex_{}", k).c_str(), k == 6 ? 30 : error_px, k == 6));
    }
    trials[i].pose_trial().estimates = {estimate("orpe", 1), estimate("lspe", 2),
                                        estimate("oracle", 0.5)};
  }
  return trials;
}

Study cube_study() {
  Study study = two_poses();
  study.target = load_target("cube");
  study.camera = centred_camera(512, 512, 15000);
  return study;
}

TEST(Summary, BoundsThePoseByTheInliersNoise) {
  const Study study = cube_study();
  const std::vector<TrialRecord> trials = cube_trials(2, 2);
  const Summary summary = summarise(study, trials);
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < 6; ++k) points.push_back(study.target->features[k].position_m);
  const auto bound = cramer_rao_bound(study.camera, points, trials[0].true_cam_from_target,
                                      std::sqrt(2.0));  // 2 px in all is sqrt(2) a coordinate
  ASSERT_TRUE(bound);
  const double degree = std::acos(-1.0) / 180;
  const CellObservations& cell = summary.observations[0];
  EXPECT_NEAR(cell.bound_theta_deg, bound->attitude_rms_rad / degree, 1e-9);
  EXPECT_NEAR(cell.bound_t_percent, 100 * bound->translation_rms, 1e-9);
  EXPECT_NEAR(cell.bound_geodesic_deg, bound->geodesic_rms_rad / degree, 1e-9);
  EXPECT_NEAR(cell_of(summary, 0, "lspe").ratio_to_bound, 2 / cell.bound_geodesic_deg, 1e-9);
}

TEST(Summary, WeighsEachFeatureInTheBoundByItsOwnNoise) {
  const Study study = cube_study();
  const auto bound_deg = [&](double first_px, double other_px) {
    return summarise(study, cube_trials(first_px, other_px)).observations[0].bound_geodesic_deg;
  };
  EXPECT_NEAR(bound_deg(4, 4), 2 * bound_deg(2, 2), 1e-9);
  // One bad feature costs something, but far less than the same noise on all would.
  EXPECT_GT(bound_deg(5, 1), bound_deg(1, 1));
  EXPECT_LT(bound_deg(5, 1), 2 * bound_deg(1, 1));
}

TEST(Summary, HasNoBoundWithoutEnoughInliers) {
  std::vector<TrialRecord> trials = cube_trials(1, 1);
  for (TrialRecord& trial : trials) trial.pose_trial().observations.resize(2);
  EXPECT_TRUE(std::isnan(summarise(cube_study(), trials).observations[0].bound_theta_deg));
}

TEST(Summary, LeavesFeaturesThatTheTargetNoLongerHasOutOfTheBound) {
  const Study study = cube_study();
  std::vector<TrialRecord> with_stranger = cube_trials(2, 1);
  std::vector<TrialRecord> without = with_stranger;
  for (TrialRecord& trial : with_stranger) trial.pose_trial().observations[0].feature = "chimney";
  for (TrialRecord& trial : without)
    trial.pose_trial().observations.erase(trial.pose_trial().observations.begin());
  const CellObservations expected = summarise(study, without).observations[0];
  const CellObservations cell = summarise(study, with_stranger).observations[0];
  EXPECT_GT(expected.bound_geodesic_deg, 0);
  EXPECT_EQ(cell.bound_geodesic_deg, expected.bound_geodesic_deg);
  EXPECT_EQ(cell.bound_t_percent, expected.bound_t_percent);
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

TEST(Summary, HasWilsonIntervalsOfItsRates) {
  const Summary summary = summarise(two_poses(), handmade_trials());
  const CellSummary& orpe = cell_of(summary, 0, "orpe");
  EXPECT_EQ(orpe.failure_rate_ci95, wilson_interval(1, 3));
  EXPECT_EQ(orpe.exact_set_rate_ci95, wilson_interval(1, 3));
  EXPECT_LT(orpe.ratio_to_oracle_ci95[0], orpe.ratio_to_oracle);
  EXPECT_GT(orpe.ratio_to_oracle_ci95[1], orpe.ratio_to_oracle);
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
  EXPECT_DOUBLE_EQ(nees.coverage95, 2 / 3.0);
  EXPECT_EQ(nees.coverage95_ci95, wilson_interval(2, 3));
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
  const std::string csv = to_csv(study, trials);
  std::reverse(trials.begin(), trials.end());
  EXPECT_EQ(to_json(study, summarise(study, trials)), json);
  EXPECT_EQ(to_csv(study, trials), csv);
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

// ---- summary.json ----

std::vector<std::string> keys_of(const Json& json) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  return keys;
}

Json handmade_json() {
  return Json::parse(to_json(two_poses(), summarise(two_poses(), handmade_trials())));
}

TEST(SummaryJson, HasTheKeysOfTheContract) {
  const Json json = handmade_json();
  EXPECT_THAT(keys_of(json),
              ElementsAre("study", "seed", "cells", "observations", "features", "extraction"));
  ASSERT_EQ(json["extraction"].size(), json["observations"].size());
  ASSERT_EQ(json["cells"].size(), 6);
  for (const Json& cell : json["cells"]) {
    EXPECT_THAT(keys_of(cell),
                ElementsAre("condition", "solver", "trials", "failures", "theta_error_deg",
                            "t_error_percent", "geodesic_deg", "ratio_to_oracle", "ratio_to_bound",
                            "false_removals", "missed_outliers", "exact_set_rate", "capped",
                            "failure_rate_ci95", "exact_set_rate_ci95", "ratio_to_oracle_ci95",
                            "ratio_to_bound_ci95", "nees"));
    for (const char* error : {"theta_error_deg", "t_error_percent", "geodesic_deg"}) {
      EXPECT_THAT(keys_of(cell[error]), ElementsAre("mean", "mean_ci95", "median", "median_ci95",
                                                    "rms", "rms_ci95", "p90", "p90_ci95"));
      EXPECT_TRUE(cell[error]["mean"].is_number());
      EXPECT_EQ(cell[error]["mean_ci95"].size(), 2);
    }
    EXPECT_TRUE(cell["trials"].is_number_integer());
    EXPECT_TRUE(cell["failures"].is_number_integer());
    EXPECT_TRUE(cell["capped"].is_number_integer());
  }
  for (const Json& cell : json["observations"]) {
    EXPECT_THAT(keys_of(cell),
                ElementsAre("condition", "trials", "trials_repeated", "found_per_trial",
                            "outliers_per_trial", "inlier_rms_px", "bound_theta_deg",
                            "bound_t_percent", "bound_geodesic_deg"));
  }
  ASSERT_EQ(json["features"].size(), 3);
  for (const Json& feature : json["features"]) {
    EXPECT_THAT(keys_of(feature),
                ElementsAre("condition", "feature", "trials_visible", "trials_found",
                            "trials_outlier", "inlier_rms_px", "median_error_px"));
  }
}

TEST(SummaryJson, SaysWhatTheSummarySays) {
  const Summary summary = summarise(two_poses(), handmade_trials());
  const Json json = handmade_json();
  EXPECT_EQ(json["study"], "tiny");
  EXPECT_EQ(json["seed"], 7);
  const Json& orpe = json["cells"][0];
  EXPECT_EQ(orpe["solver"], "orpe");
  EXPECT_EQ(orpe["failures"], 1);
  EXPECT_EQ(orpe["capped"], 1);
  EXPECT_EQ(orpe["geodesic_deg"]["rms"].get<double>(), summary.cells[0].geodesic_deg.rms);
  EXPECT_EQ(orpe["geodesic_deg"]["mean_ci95"][1].get<double>(),
            summary.cells[0].geodesic_deg.mean_ci95[1]);
  EXPECT_EQ(orpe["ratio_to_oracle"].get<double>(), summary.cells[0].ratio_to_oracle);
}

TEST(SummaryJson, WritesKeysThatAreWholeNumbersThroughoutAsIntegers) {
  const Json json = handmade_json();
  const Json& condition = json["cells"][3]["condition"];
  EXPECT_TRUE(condition["pose"].is_number_integer());
  EXPECT_EQ(condition["pose"], 2);
  EXPECT_TRUE(condition["noise_px"].is_number_float()) << "the other condition has 0.5";
  EXPECT_EQ(condition["noise_px"], 2.0);
}

TEST(SummaryJson, WritesNullForWhatIsNoNumber) {
  const Json json = handmade_json();
  const Json& dark = json["cells"][3];
  EXPECT_TRUE(dark["geodesic_deg"]["median"].is_null());
  EXPECT_TRUE(dark["ratio_to_bound"].is_null());
  EXPECT_TRUE(json["observations"][1]["inlier_rms_px"].is_null());
  EXPECT_EQ(dark["geodesic_deg"]["mean"], 20);
}

// ---- results.csv ----

using Row = std::map<std::string, std::string>;

// The fields of an RFC 4180 text, written without a look at the writer.
std::vector<std::vector<std::string>> parse_csv(const std::string& text) {
  std::vector<std::vector<std::string>> lines(1, {""});
  bool is_quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (is_quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      lines.back().back() += text[++i];
    } else if (c == '"') {
      is_quoted = !is_quoted;
    } else if (c == ',' && !is_quoted) {
      lines.back().emplace_back();
    } else if (c == '\n' && !is_quoted) {
      lines.push_back({""});
    } else {
      lines.back().back() += c;
    }
  }
  lines.pop_back();
  return lines;
}

std::vector<Row> rows_of(const Study& study, const std::vector<TrialRecord>& trials) {
  const auto lines = parse_csv(to_csv(study, trials));
  std::vector<Row> rows;
  for (size_t i = 1; i < lines.size(); ++i) {
    EXPECT_EQ(lines[i].size(), lines[0].size()) << "line " << i;
    Row& row = rows.emplace_back();
    for (size_t k = 0; k < lines[0].size(); ++k) row[lines[0][k]] = lines[i][k];
  }
  return rows;
}

TEST(ResultsCsv, HasItsHeaderAndARowATrialAndSolver) {
  const std::string csv = to_csv(two_poses(), handmade_trials());
  EXPECT_EQ(csv.substr(0, csv.find('\n')),
            "trial,condition,noise_px,pose,solver,status,theta_error_deg,t_error_percent,"
            "geodesic_deg,reprojection_rms_px,add_m,mssd_m,mspd_px,nees,removed,false_removals,"
            "missed_outliers,found,outliers,qw,qx,qy,qz,tx_m,ty_m,tz_m,true_qw,true_qx,true_qy,"
            "true_qz,true_tx_m,true_ty_m,true_tz_m,ambiguous,removed_probability,"
            "removal_limit_reached,test_failed");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 12);
  EXPECT_EQ(csv.back(), '\n');
  std::vector<std::string> order;
  for (const Row& row : rows_of(two_poses(), handmade_trials())) {
    order.push_back(row.at("trial") + " " + row.at("solver"));
  }
  order.resize(4);
  EXPECT_THAT(order, ElementsAre("0 orpe", "0 lspe", "0 oracle", "1 orpe"));
}

TEST(ResultsCsv, SaysWhatBecameOfATrial) {
  const Row row = rows_of(two_poses(), handmade_trials())[9];
  EXPECT_EQ(row.at("trial"), "4");
  EXPECT_EQ(row.at("condition"), "pose 1");
  EXPECT_EQ(row.at("noise_px"), "0.5");
  EXPECT_EQ(row.at("solver"), "orpe");
  EXPECT_EQ(row.at("status"), "ok");
  EXPECT_EQ(row.at("geodesic_deg"), "2");
  EXPECT_EQ(row.at("removed"), "a;b");
  EXPECT_EQ(row.at("false_removals"), "1");
  EXPECT_EQ(row.at("found"), "3");
  EXPECT_EQ(row.at("outliers"), "0");
}

TEST(ResultsCsv, LeavesAFailuresNumbersEmptyAndCountsItsOutliersAsMissed) {
  const Row row = rows_of(two_poses(), handmade_trials())[6];
  EXPECT_EQ(row.at("status"), "degenerate");
  for (const char* key :
       {"theta_error_deg", "t_error_percent", "geodesic_deg", "reprojection_rms_px", "add_m",
        "mssd_m", "mspd_px", "removed", "qw", "qz", "tx_m", "tz_m"}) {
    EXPECT_EQ(row.at(key), "") << key;
  }
  EXPECT_EQ(row.at("false_removals"), "0");
  EXPECT_EQ(row.at("missed_outliers"), "1");
  EXPECT_EQ(row.at("true_qw"), "1") << "the truth is there all the same";
}

TEST(ResultsCsv, EndsWithWhatTheSolverSaysAndIsEmptyWhereItSaysNothing) {
  std::vector<TrialRecord> trials = handmade_trials();
  EstimateRecord& estimate = trials[0].pose_trial().estimates[0];
  estimate.is_ambiguous = true;
  estimate.removed_probability = 0.75;
  estimate.is_removal_limit_reached = false;
  const std::vector<Row> rows = rows_of(two_poses(), trials);
  EXPECT_EQ(rows[0].at("ambiguous"), "1");
  EXPECT_EQ(rows[0].at("removed_probability"), "0.75");
  EXPECT_EQ(rows[0].at("removal_limit_reached"), "0");
  EXPECT_EQ(rows[0].at("test_failed"), "");
  for (const char* key : {"ambiguous", "removed_probability", "removal_limit_reached"}) {
    EXPECT_EQ(rows[1].at(key), "") << key;
  }
}

TEST(ResultsCsv, ReadsBackTheSameNumbers) {
  std::vector<TrialRecord> trials = handmade_trials();
  RandomStream random(1, "csv", 0);
  trials[0].true_cam_from_target = {random.rotation(), 1300 * random.normal3()};
  trials[0].pose_trial().estimates[0].cam_from_target = {random.rotation(),
                                                         1e-7 * random.normal3()};
  trials[0].pose_trial().estimates[0].theta_error_deg = 1.0 / 3;
  const Row row = rows_of(two_poses(), trials)[0];
  const auto value = [&row](const std::string& key) { return std::stod(row.at(key)); };
  const auto expect_pose = [&value](const std::string& prefix, const Pose& pose) {
    EXPECT_EQ(value(prefix + "tx_m"), pose.translation.x());
    EXPECT_EQ(value(prefix + "ty_m"), pose.translation.y());
    EXPECT_EQ(value(prefix + "tz_m"), pose.translation.z());
    const Eigen::Vector4d quaternion(value(prefix + "qw"), value(prefix + "qx"),
                                     value(prefix + "qy"), value(prefix + "qz"));
    EXPECT_EQ(quaternion, quaternion_wxyz(pose.rotation));
  };
  EXPECT_EQ(value("theta_error_deg"), 1.0 / 3);
  expect_pose("", trials[0].pose_trial().estimates[0].cam_from_target);
  expect_pose("true_", trials[0].true_cam_from_target);
}

TEST(ResultsCsv, QuotesWhatNeedsIt) {
  Study study = two_poses();
  study.conditions[0].label = "near, \"bright\"\nand steep";
  study.conditions[1].values.erase("noise_px");
  const std::vector<Row> rows = rows_of(study, handmade_trials());
  EXPECT_EQ(rows[0].at("condition"), "near, \"bright\"\nand steep");
  EXPECT_EQ(rows[0].at("noise_px"), "0.5");
  EXPECT_EQ(rows[3].at("condition"), "pose 2");
  EXPECT_EQ(rows[3].at("noise_px"), "") << "a value that only the other condition has";
}

}  // namespace
}  // namespace sightline
