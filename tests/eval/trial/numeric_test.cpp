// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Studies that draw no images: numeric ones, and those of the absolute orientation.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "eval/results/results_csv.h"
#include "eval/study/study_file.h"
#include "eval/summary/summary.h"
#include "eval/summary/summary_json.h"
#include "eval/tables/sweep_table.h"
#include "eval/trial/numeric_trial.h"
#include "eval/trial/orientation_trial.h"
#include "pose/attitude.h"
#include "tests/eval/studies.h"
#include "tests/scenes/error_text.h"
#include "eval/summary/claims.h"

namespace sightline {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Settings = std::vector<std::string>;

Study study_with(const std::string& name, int trials, const Settings& settings = {}) {
  return read_study(name, {.trials = trials, .seed = {}, .set = settings});
}

std::vector<TrialRecord> run_all(const Study& study) {
  std::vector<TrialRecord> trials;
  for (int64_t i = 0; i < study.trial_count(); ++i) {
    trials.push_back(study.numeric() != nullptr ? run_numeric_trial(study, i)
                                                : run_orientation_trial(study, i));
  }
  return trials;
}

std::string study_error(const std::string& name, const Settings& settings) {
  return error_of([&] { study_with(name, 1, settings); });
}

std::vector<ObservationRecord> outliers_of(const TrialRecord& trial) {
  std::vector<ObservationRecord> outliers;
  for (const ObservationRecord& o : trial.observations()) {
    if (o.is_outlier) outliers.push_back(o);
  }
  return outliers;
}

// A study of nothing but planted outliers: what moves a pixel is the law.
std::vector<TrialRecord> planted(const std::string& law, int count) {
  return run_all(
      study_with("cube-outliers", 200,
                 {"noise.scale=0", "outliers.law=" + law,
                  "sweep.outliers=[" + std::to_string(count) + "]", "solvers=['oracle']"}));
}

TEST(NumericStudy, ConditionsHaveTheNamesOfTheContract) {
  const Study noise = read_study("cube-noise");
  ASSERT_EQ(noise.conditions.size(), 9u);
  EXPECT_EQ(noise.conditions[3].values, (std::map<std::string, double>{{"noise_px", 1.5}}));
  EXPECT_EQ(noise.numeric()->cells[3].noise_px, 1.5);
  EXPECT_EQ(noise.numeric()->cells[3].outliers, 1);
  const Study outliers = read_study("cube-outliers");
  ASSERT_EQ(outliers.conditions.size(), 4u);
  EXPECT_EQ(outliers.conditions[3].values, (std::map<std::string, double>{{"outliers", 3}}));
  EXPECT_EQ(outliers.numeric()->cells[3].noise_px, 2);
  EXPECT_EQ(outliers.numeric()->features.size(), 8u);
  EXPECT_EQ(outliers.numeric()->solving.start, Start::kFree);
}

TEST(NumericStudy, SweepsTwoQuantitiesAsTheirProduct) {
  const Study study = study_with("cube-noise", 1, {"outliers={}", "sweep.outliers=[0, 2]"});
  ASSERT_EQ(study.conditions.size(), 18u);
  EXPECT_EQ(study.conditions[9].values,
            (std::map<std::string, double>{{"noise_px", 0}, {"outliers", 2}}));
}

TEST(NumericStudy, NoiseScaleIsNotPartOfTheCondition) {
  const Study study = study_with("cube-noise", 1, {"noise.scale=3"});
  EXPECT_EQ(study.conditions[2].values.at("noise_px"), 1);
  EXPECT_EQ(study.numeric()->cells[2].noise_px, 3);
}

TEST(NumericStudy, SolverOptionsReachTheSolvers) {
  const Study study = study_with(
      "cube-noise", 1,
      {"solver.final=least_squares", "solver.outlier_probability=0.2", "solver.outlier_scale_px=15",
       "solver.false_alarm_rate=0.05", "solver.max_removed=2"});
  EXPECT_EQ(study.numeric()->solving.options.orpe.final, OrpeOptions::Final::kLeastSquares);
  EXPECT_EQ(study.numeric()->solving.options.outliers.probability, 0.2);
  EXPECT_EQ(study.numeric()->solving.options.outliers.scale_px, 15);
  EXPECT_EQ(study.numeric()->solving.options.outliers.false_alarm_rate, 0.05);
  EXPECT_EQ(study.numeric()->solving.options.outliers.max_removed, 2);
  EXPECT_FALSE(read_study("cube-noise").numeric()->solving.options.outliers.max_removed.has_value());
}

TEST(NumericStudy, MistakesGetOneClearLine) {
  for (const auto& [setting, reason] : std::map<std::string, std::string>{
           {"kind=numerical", "did you mean 'numeric'"},
           {"outliers.law=cluster", "'clustered'"},
           {"outliers.size_px=[30, 15]", "[low, high]"},
           {"outliers.count=9", "from 0 to 8"},
           {"outliers.count=1.5", "whole numbers"},
           {"outliers.law=swapped", "in pairs"},
           {"noise.pixel_px=2", "cannot stand beside noise.pixel_px"},
           {"sweep.noise_px=[]", "one or more"},
           {"sweep.noise_px=[1, 'two']", "must hold numbers only"},
           {"sweep.noise_px=[1, 1]", "twice"},
           {"sweep.noise=[1]", "or one of noise_px, outliers"},
           {"solver.sigma=1", "solver.sigma"},
           {"solver.final=minmax", "'minimax'"},
           {"solver.max_removed=-1", "from 0"},
           {"image.bits=8", "image"},
           {"poses.range_m=[0, 1]", "[low, high]"}}) {
    const std::string error = study_error("cube-noise", {setting});
    EXPECT_THAT(error, HasSubstr(reason)) << setting;
    EXPECT_THAT(error, testing::Not(HasSubstr("\n"))) << setting;
  }
  EXPECT_THAT(study_error("boeing-random", {"solver.sigma=known"}), HasSubstr("sigma"))
      << "images give covariances";
}

TEST(OrientationStudy, MistakesGetOneClearLine) {
  for (const auto& [setting, reason] :
       std::map<std::string, std::string>{{"methods=['fats']", "did you mean 'fast'"},
                                          {"methods=[]", "at least one"},
                                          {"methods=['fast', 'fast']", "twice"},
                                          {"sweep.points=[2]", "from 3"},
                                          {"sweep.points=[3.5]", "whole numbers"},
                                          {"copies=0", "copies"},
                                          {"solvers=['orpe']", "solvers"},
                                          {"target=cube", "target"},
                                          {"noise.sigma_m=-1", "noise.sigma_m"}}) {
    const std::string error = study_error("orientation-points", {setting});
    EXPECT_THAT(error, HasSubstr(reason)) << setting;
    EXPECT_THAT(error, testing::Not(HasSubstr("\n"))) << setting;
  }
}

TEST(NumericTrial, DependsOnNothingButStudyAndIndex) {
  const Study small = study_with("cube-noise", 2);
  const Study large = study_with("cube-noise", 5);
  const TrialRecord a = run_numeric_trial(small, 12);
  const TrialRecord b = run_numeric_trial(large, 12);
  ASSERT_EQ(a.observations().size(), 8u);
  for (size_t i = 0; i < a.observations().size(); ++i) {
    EXPECT_EQ(a.observations()[i].pixel, b.observations()[i].pixel);
    EXPECT_EQ(a.observations()[i].is_outlier, b.observations()[i].is_outlier);
  }
  for (size_t i = 0; i < a.estimates().size(); ++i) {
    EXPECT_EQ(a.estimates()[i].geodesic_deg, b.estimates()[i].geodesic_deg);
  }
  const TrialRecord c = run_numeric_trial(small, 3);
  EXPECT_EQ(c.condition, a.condition);
  EXPECT_NE(c.true_cam_from_target.translation, a.true_cam_from_target.translation);
}

TEST(NumericTrial, DrawsPosesByTheLaw) {
  double least_cosine = 1;
  for (const TrialRecord& trial : planted("uniform", 1)) {
    const Eigen::Vector3d& t = trial.true_cam_from_target.translation;
    EXPECT_LE(std::max(std::abs(t.x()), std::abs(t.y())), 0.3);
    EXPECT_TRUE(50 <= t.z() && t.z() <= 150) << t.z();
    least_cosine = std::min(least_cosine, trial.true_cam_from_target.rotation(2, 2));
  }
  EXPECT_LT(least_cosine, -0.9) << "uniform on SO(3): some are upside down";

  const Study study = study_with("cube-noise", 20, {"poses.angle_deg=[-60, 60]"});
  for (const TrialRecord& trial : run_all(study)) {
    const Attitude theta = attitude_from_rotation(trial.true_cam_from_target.rotation);
    for (const double angle_rad : {theta.pitch_rad, theta.yaw_rad, theta.roll_rad}) {
      EXPECT_LE(std::abs(angle_rad), 60 * M_PI / 180 + 1e-12);
    }
  }
}

TEST(NumericTrial, NoiseHasTheStatedDeviation) {
  const Study study = study_with("cube-outliers", 1000,
                                 {"sweep.outliers=[0]", "noise.scale=0.5", "solvers=['oracle']"});
  double squares = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (const TrialRecord& trial : run_all(study)) {
    for (const ObservationRecord& o : trial.observations()) {
      const Eigen::Vector2d noise = o.pixel - o.true_pixel;  // of 1 px: 2 px halved
      EXPECT_DOUBLE_EQ(o.error_px, noise.norm());
      squares += noise.squaredNorm();
      sum += noise;
      count += 2;
    }
  }
  // Chi-square of 16000 degrees of freedom, and a mean of 8000 values: four deviations.
  EXPECT_NEAR(squares, count, 4 * std::sqrt(2.0 * count));
  EXPECT_LT(sum.cwiseAbs().maxCoeff(), 4 * std::sqrt(count / 2.0));
}

TEST(NumericTrial, PlantsUniformOutliersOfTheStatedSize) {
  double least = 30, greatest = 15;
  std::set<std::string> features;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const TrialRecord& trial : planted("uniform", 3)) {
    const auto outliers = outliers_of(trial);
    ASSERT_EQ(outliers.size(), 3u);
    for (const ObservationRecord& o : outliers) {
      features.insert(o.feature);
      sum += (o.pixel - o.true_pixel).normalized();
      least = std::min(least, o.error_px);
      greatest = std::max(greatest, o.error_px);
    }
    EXPECT_NE(outliers[0].error_px, outliers[1].error_px);
    for (const ObservationRecord& o : trial.observations()) {
      EXPECT_EQ(o.error_px == 0, !o.is_outlier);
    }
  }
  EXPECT_GE(least, 15 - 1e-9);
  EXPECT_LE(greatest, 30 + 1e-9);
  EXPECT_GT(greatest - least, 14);
  EXPECT_EQ(features.size(), 8u) << "every vertex is one now and then";
  EXPECT_LT(sum.norm(), 4 * std::sqrt(600)) << "no direction is preferred";
}

TEST(NumericTrial, PlantsFixedAndClusteredOutliers) {
  std::set<double> directions;
  for (const TrialRecord& trial : planted("fixed", 2)) {
    ASSERT_EQ(outliers_of(trial).size(), 2u);
    for (const ObservationRecord& o : outliers_of(trial)) {
      EXPECT_NEAR(o.error_px, 30, 1e-9);
      directions.insert(std::atan2(o.pixel.y() - o.true_pixel.y(), o.pixel.x() - o.true_pixel.x()));
    }
  }
  EXPECT_EQ(directions.size(), 400u);
  for (const TrialRecord& trial : planted("clustered", 3)) {
    const auto outliers = outliers_of(trial);
    ASSERT_EQ(outliers.size(), 3u);
    const Eigen::Vector2d shift = outliers[0].pixel - outliers[0].true_pixel;
    for (const ObservationRecord& o : outliers) {
      EXPECT_LT((o.pixel - o.true_pixel - shift).norm(), 1e-9);
      EXPECT_TRUE(15 - 1e-9 <= o.error_px && o.error_px <= 30 + 1e-9);
    }
  }
}

TEST(NumericTrial, SwapsMirroredPairs) {
  const Study study = read_study("cube-noise");
  for (const TrialRecord& trial : planted("swapped", 4)) {
    const auto outliers = outliers_of(trial);
    ASSERT_EQ(outliers.size(), 4u);
    for (const ObservationRecord& o : outliers) {
      const auto other = std::find_if(outliers.begin(), outliers.end(),
                                      [&](const auto& p) { return p.true_pixel == o.pixel; });
      ASSERT_NE(other, outliers.end());
      EXPECT_EQ(other->pixel, o.true_pixel);
    }
  }
  EXPECT_THAT(study_error("cube-outliers", {"outliers.law=swapped", "sweep.outliers=[0, 3]"}),
              AllOf(HasSubstr("outliers.law"), HasSubstr("even")));
  EXPECT_THAT(
      study_error("cube-outliers", {"outliers.law=swapped", "sweep.outliers=[4]",
                                    "features=['vertex_0', 'vertex_2', 'vertex_4', 'vertex_7']"}),
      HasSubstr("only 2 of the features mirror"));
}

// Keeps what it was given.
std::vector<PoseProblem> spied_problems;
PoseEstimate spy(const PoseProblem& problem, const SolverOptions&) {
  spied_problems.push_back(problem);
  return {};
}
constexpr PoseSolver kSpy{"spy", "keeps its problem", false, spy};
constexpr PoseSolver kToldSpy{"told spy", "keeps its problem", true, spy};

std::vector<PoseProblem> problems_of(const Settings& settings) {
  Study study = study_with("cube-outliers", 1, settings);
  numeric_of(study).solving.solvers = {built_in(kSpy), built_in(kToldSpy)};
  spied_problems.clear();
  run_numeric_trial(study, 2);  // two outliers
  return spied_problems;
}

TEST(NumericTrial, TellsSolversWhatTheStudySaysAndNoMore) {
  const auto plain = problems_of({});
  ASSERT_EQ(plain.size(), 2u);
  EXPECT_EQ(plain[0].points_in_target.size(), 8u);
  EXPECT_EQ(plain[0].sigma_px, 2);
  EXPECT_EQ(problems_of({"solver.sigma=unknown"})[0].sigma_px, 0);
  EXPECT_FALSE(plain[0].initial_cam_from_target.has_value());
  EXPECT_TRUE(plain[0].true_inliers.empty());
  EXPECT_TRUE(plain[0].covariances_px2.empty());
  EXPECT_EQ(std::count(plain[1].true_inliers.begin(), plain[1].true_inliers.end(), false), 2);
  EXPECT_EQ(problems_of({"noise.scale=2"})[0].sigma_px, 4);
  EXPECT_TRUE(problems_of({"solver.start=prior"})[0].initial_cam_from_target.has_value());
}

TEST(NumericTrial, APoseBehindTheCameraIsAFailedRow) {
  const Study study = study_with("cube-noise", 20, {"poses.range_m=[0.01, 0.02]"});
  const std::vector<TrialRecord> trials = run_all(study);
  EXPECT_TRUE(trials[0].observations().empty());
  ASSERT_EQ(trials[0].estimates().size(), study.solvers().size());
  EXPECT_EQ(trials[0].estimates()[0].status, EstimateOutcome::kNotImaged);
}

TEST(NumericSummary, LeastSquaresIsOnTheBoundWithoutOutliersAndOffItWithOne) {
  const Study study = study_with("cube-outliers", 1000,
                                 {"sweep.outliers=[0, 1]", "noise.pixel_px=1", "solvers=['lspe']"});
  const Summary summary = summarise(study, run_all(study));
  // The RMS of 1000 errors, each of two to three degrees of freedom, is known to about 2 %.
  EXPECT_NEAR(summary.cells[0].ratio_to_bound, 1, 0.08);
  EXPECT_GT(summary.cells[1].ratio_to_bound, 2);
  EXPECT_EQ(summary.cells[0].exact_set_rate, 1);
  EXPECT_EQ(summary.cells[1].exact_set_rate, 0);
  EXPECT_EQ(summary.observations[1].outliers, 1);
  // Known of this cube, camera and law of poses.
  EXPECT_NEAR(summary.observations[0].bound_geodesic_deg, 0.445, 0.03);
}

TEST(NumericSummary, ReportedCovariancesFitTheErrorsOfTheNoiseThatSolversWereTold) {
  const Settings settings = {"sweep.outliers=[0, 1]", "noise.pixel_px=0.5", "solvers=['lspe']"};
  const Study study = study_with("cube-outliers", 1000, settings);
  const Summary summary = summarise(study, run_all(study));
  const NeesSummary& nees = summary.cells[0].nees;
  EXPECT_EQ(nees.trials, 1000);
  // Chi-squared with 6 degrees of freedom has variance 12; four deviations of 1000 trials.
  EXPECT_NEAR(nees.mean, 6, 4 * std::sqrt(12 / 1000.0));
  EXPECT_NEAR(nees.coverage95, 0.95, 4 * std::sqrt(0.05 * 0.95 / 1000));
  EXPECT_LT(summary.cells[1].nees.coverage95, 0.5) << "an outlier is not in the covariance";
  // Told nothing of the noise, least squares reports no covariance.
  Settings untold = settings;
  untold.push_back("solver.sigma=unknown");
  const Study secret = study_with("cube-outliers", 5, untold);
  EXPECT_EQ(summarise(secret, run_all(secret)).cells[0].nees.trials, 0);
}

TEST(NumericSummary, BoundFollowsTheNoiseAppliedAndThereIsNoneWithoutNoise) {
  const Study study = study_with("cube-noise", 20);
  const Study louder = study_with("cube-noise", 20, {"noise.scale=2"});
  const Summary a = summarise(study, run_all(study));
  const Summary b = summarise(louder, run_all(louder));
  EXPECT_NEAR(b.observations[1].bound_geodesic_deg, 2 * a.observations[1].bound_geodesic_deg,
              1e-9 * b.observations[1].bound_geodesic_deg);
  EXPECT_TRUE(std::isnan(a.observations[0].bound_geodesic_deg));
  const auto json = nlohmann::json::parse(to_json(study, a));
  EXPECT_EQ(json["cells"][0]["condition"].dump(), R"({"noise_px":0.0})");
  EXPECT_TRUE(json["cells"][0]["ratio_to_bound"].is_null());
  EXPECT_TRUE(json["cells"][0]["ratio_to_oracle"].is_null());
  EXPECT_EQ(json["cells"].back()["condition"].dump(), R"({"noise_px":4.0})");
  EXPECT_GT(json["cells"].back()["ratio_to_bound"].get<double>(), 0);
  EXPECT_LT(json["cells"][0]["geodesic_deg"]["rms"].get<double>(), 1e-6) << "ORPE, exact pixels";
}

TEST(ClaimVerdicts, NameTheConditionsBeyondTheLimits) {
  const auto verdicts = [](const Settings& settings) {
    const Study study = study_with("cube-outliers", 20, settings);
    return claim_verdicts(study, summarise(study, run_all(study)));
  };
  EXPECT_THAT(
      verdicts({"limits.theta_error_deg=1.5"}),
      ElementsAre(HasSubstr("theta_error is below 1.5 degrees but at 2 outliers, 3 outliers"),
                  HasSubstr("T_error is below 0.9 percent but at")));
  EXPECT_THAT(verdicts({"limits.theta_error_deg=100", "limits.t_error_percent=0"}),
              ElementsAre(HasSubstr("in every condition"), HasSubstr("in no condition")));
  EXPECT_THAT(verdicts({"solvers=['lspe']"}), IsEmpty()) << "the claim is ORPE's";
  EXPECT_THAT(study_error("cube-outliers", {"limits.solver=nobody"}), HasSubstr("limits.solver"));
  EXPECT_THAT(study_error("cube-outliers", {"limits.t_error_percent=-1"}),
              HasSubstr("limits.t_error_percent"));
}

TEST(ClaimVerdicts, HoldTheFastFormAgainstUmeyama) {
  const auto verdicts = [](const Settings& settings) {
    const Study study = study_with("orientation-points", 2, settings);
    return claim_verdicts(study, summarise(study, run_all(study)));
  };
  EXPECT_THAT(verdicts({"copies=2"}), ElementsAre("fast errs 1.0000 to 1.0000 times as much as "
                                                  "umeyama."));
  EXPECT_THAT(verdicts({"copies=2", "methods=['fast']"}), IsEmpty());
}

template <typename Scalar>
OrientationEstimate never(std::span<const Eigen::Matrix<Scalar, 3, 1>>,
                          std::span<const Eigen::Matrix<Scalar, 3, 1>>, std::span<const double>) {
  return {OrientationStatus::kDegenerate, {}, 1};
}
constexpr OrientationMethod kNever{"never", "fails", never<double>, never<float>};

TEST(OrientationTrial, IsExactWithoutNoiseAndGrowsWithIt) {
  const auto error_at = [](const char* scale) {
    const Study study =
        study_with("orientation-noise", 20, {std::string("noise.scale=") + scale, "copies=5"});
    const Summary summary = summarise(study, run_all(study));
    EXPECT_EQ(summary.cells.size(), 6 * study.orientation()->methods.size());
    return summary.cells[0].geodesic_deg.mean;
  };
  EXPECT_LT(error_at("0"), 1e-9);
  const double one = error_at("0.1");
  EXPECT_GT(one, 0.01);
  EXPECT_NEAR(error_at("0.2") / one, 2, 0.1) << "the same draws and copies, twice the noise";
}

TEST(OrientationTrial, CountsACopyWithoutARotationAsTheCap) {
  Study study = study_with("orientation-points", 2, {"copies=5"});
  orientation_of(study).methods.push_back(&kNever);
  const Summary summary = summarise(study, run_all(study));
  const CellSummary& cell = summary.cells[study.orientation()->methods.size() - 1];
  EXPECT_EQ(cell.solver, "never");
  EXPECT_EQ(cell.failures, 2);
  EXPECT_EQ(cell.failed_copies, 10);
  EXPECT_EQ(cell.geodesic_deg.mean, kAngleCapDeg);
  EXPECT_EQ(summary.cells[0].failures, 0);
  EXPECT_EQ(run_orientation_trial(study, 0).orientations().back().status,
            EstimateOutcome::kDegenerate);
}

TEST(OrientationTrial, TakesTimesOnlyWhereAsked) {
  const Study timed = study_with("orientation-speed", 1, {"timed_repeats=2", "methods=['fast']"});
  const TrialRecord trial = run_orientation_trial(timed, 0);
  EXPECT_GT(trial.orientations()[0].time_ns, 0);
  const std::vector<TrialRecord> trials = {trial};
  std::ostringstream timings;
  std::ostringstream csv;
  write_timings_csv(timed, in_order(trials), timings);
  write_csv(timed, in_order(trials), csv);
  EXPECT_TRUE(timed.takes_times());
  EXPECT_THAT(timings.str(),
              testing::StartsWith("trial,condition,points,solver,time_ns\n0,3 points,3,fast,"));
  EXPECT_THAT(csv.str(), testing::Not(HasSubstr("time")));
  EXPECT_THAT(to_json(timed, summarise(timed, trials)), testing::Not(HasSubstr("time")));
  const Study untimed = study_with("orientation-points", 1);
  const TrialRecord other = run_orientation_trial(untimed, 0);
  EXPECT_TRUE(std::isnan(other.orientations()[0].time_ns));
  EXPECT_FALSE(untimed.takes_times());
}

}  // namespace
}  // namespace sightline
