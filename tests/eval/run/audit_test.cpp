// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The harness audits itself. Every test plants one fault where two real stages meet, and demands
// that what the suite reports anyway tells of it; its twin is the same flow undisturbed.
#include <algorithm>
#include <cmath>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "eval/compare/compare.h"
#include "eval/report/report.h"
#include "eval/results/store.h"
#include "eval/study/study_file.h"
#include "eval/summary/localisation.h"
#include "eval/summary/summary.h"
#include "eval/summary/summary_json.h"
#include "eval/tables/result_table.h"
#include "eval/trial/image_trial.h"
#include "eval/trial/numeric_trial.h"
#include "tests/eval/program.h"
#include "tests/eval/studies.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr int kTrials = 100;
constexpr double kRadPerDeg = M_PI / 180;

// ---- Solvers with a fault before or behind the real one ----

PoseEstimate solved(const PoseProblem& problem, const SolverOptions& options) {
  return find_pose_solver("lspe")->solve(problem, options);
}

// y of the target's points points the other way.
PoseEstimate with_flipped_target(const PoseProblem& problem, const SolverOptions& options) {
  PoseProblem faulty = problem;
  for (Eigen::Vector3d& point : faulty.points_in_target) point.y() = -point.y();
  return solved(faulty, options);
}

// y of the image points up.
PoseEstimate with_flipped_image(const PoseProblem& problem, const SolverOptions& options) {
  PoseProblem faulty = problem;
  for (Eigen::Vector2d& pixel : faulty.pixels) pixel.y() = problem.camera.height_px - 1 - pixel.y();
  return solved(faulty, options);
}

// The pose is told in a frame of the camera whose y points up and z back, as OpenGL has it.
PoseEstimate with_flipped_camera(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate = solved(problem, options);
  const Eigen::DiagonalMatrix<double, 3> flip(1, -1, -1);
  estimate.cam_from_target.rotation = flip * estimate.cam_from_target.rotation;
  estimate.cam_from_target.translation = flip * estimate.cam_from_target.translation;
  return estimate;
}

// The middle of a pixel is taken for its corner.
PoseEstimate with_half_a_pixel(const PoseProblem& problem, const SolverOptions& options) {
  PoseProblem faulty = problem;
  for (Eigen::Vector2d& pixel : faulty.pixels) pixel.array() += 0.5;
  return solved(faulty, options);
}

PoseEstimate in_millimetres(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate = solved(problem, options);
  estimate.cam_from_target.translation *= 1000;
  return estimate;
}

PoseEstimate with_transposed_rotation(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate = solved(problem, options);
  estimate.cam_from_target.rotation.transposeInPlace();
  return estimate;
}

PoseEstimate its_start(const PoseProblem& problem, const SolverOptions&) {
  PoseEstimate estimate;
  if (!problem.initial_cam_from_target) return estimate;
  estimate.status = PoseStatus::kOk;
  estimate.cam_from_target = *problem.initial_cam_from_target;
  return estimate;
}

// All under one name, so that runs compare.
constexpr PoseSolver kSound{"lspe", "", false, solved};
constexpr PoseSolver kFlippedTarget{"lspe", "", false, with_flipped_target};
constexpr PoseSolver kFlippedImage{"lspe", "", false, with_flipped_image};
constexpr PoseSolver kFlippedCamera{"lspe", "", false, with_flipped_camera};
constexpr PoseSolver kHalfAPixel{"lspe", "", false, with_half_a_pixel};
constexpr PoseSolver kMillimetres{"lspe", "", false, in_millimetres};
constexpr PoseSolver kTransposed{"lspe", "", false, with_transposed_rotation};
constexpr PoseSolver kItsStart{"lspe", "", false, its_start};

// ---- The flow without images ----

struct Flow {
  Study study;
  std::vector<TrialRecord> trials;

  Summary summary() const { return summarise(study, trials); }
  CellSummary cell() const { return summary().cells.front(); }
  CellObservations observations() const { return summary().observations.front(); }
};

Study cube_study(const std::vector<std::string>& more = {}) {
  std::vector<std::string> settings = {"sweep.outliers=[0]", "noise.pixel_px=0.5",
                                       "solvers=['lspe']", "solver.start=prior"};
  settings.insert(settings.end(), more.begin(), more.end());
  return read_study("cube-outliers", {.trials = kTrials, .seed = {}, .set = settings});
}

Flow flow_of(Study study) {
  Flow flow{std::move(study), {}};
  for (int64_t i = 0; i < flow.study.trial_count(); ++i) {
    flow.trials.push_back(run_numeric_trial(flow.study, i));
  }
  return flow;
}

Flow flow_with(const PoseSolver& solver) {
  Study study = cube_study();
  numeric_of(study).solving.solvers = {built_in(solver)};
  return flow_of(std::move(study));
}

class Audit : public testing::Test {
 protected:
  // The flow's results as a run leaves them.
  fs::path write(const std::string& name, const Flow& flow) const {
    const fs::path run = folder_.path() / name;
    fs::create_directories(run);
    Store::create(run / "results.sqlite", {{"trials", fmt::format("{}", flow.study.trial_count())}})
        .add(flow.trials);
    folder_.write(name + "/summary.json", to_json(flow.study, flow.summary()));
    return run;
  }

  // What the gate says of the flow, against the sound one.
  Comparison gate(const Flow& flow) const {
    return compare_runs(write("sound", flow_with(kSound)), write("faulty", flow), 0);
  }

  TemporaryFolder folder_;
};

Verdict verdict_of(const Comparison& comparison, const std::string& quantity) {
  const auto& differences = comparison.cells.front().differences;
  return std::find_if(differences.begin(), differences.end(),
                      [&](const Difference& d) { return d.quantity == quantity; })
      ->verdict;
}

double mean_reprojection_px(const Flow& flow) {
  double sum = 0;
  for (const TrialRecord& trial : flow.trials) sum += trial.estimates()[0].reprojection_rms_px;
  return sum / static_cast<double>(flow.trials.size());
}

TEST_F(Audit, TheSoundFlowIsWithinEveryMeasuresNormalRange) {
  const Flow flow = flow_with(kSound);
  const CellSummary cell = flow.cell();
  EXPECT_EQ(cell.failures, 0);
  // Four deviations: the RMS of 100 errors of two to three degrees of freedom is known to 6 %, the
  // mean of chi-squared numbers (6 degrees of freedom, variance 12) to sqrt(12 / 100).
  EXPECT_NEAR(cell.ratio_to_bound, 1, 0.25);
  EXPECT_NEAR(cell.nees.mean, 6, 4 * std::sqrt(12.0 / kTrials));
  EXPECT_LT(mean_reprojection_px(flow), 0.5 * std::sqrt(2.0));
  EXPECT_EQ(flow.observations().repeated, 0);
  EXPECT_EQ(flow.observations().trials, kTrials);
  EXPECT_THAT(to_table(flow.study, flow.summary()), Not(HasSubstr("warning")));

  // Another start for the same solver is no regression.
  const Flow free = flow_of(cube_study({"solver.start=free"}));
  EXPECT_FALSE(gate(free).has_regression());
}

TEST_F(Audit, AFlippedAxisOfTheTargetIsNoticed) {
  const Flow flow = flow_with(kFlippedTarget);
  EXPECT_GT(flow.cell().ratio_to_bound, 10);
  EXPECT_GT(mean_reprojection_px(flow), 5) << "a mirrored body fits no image of the right one";
  EXPECT_EQ(verdict_of(gate(flow), "geodesic_deg.mean"), Verdict::kWorse);
}

TEST_F(Audit, AFlippedAxisOfTheImageIsNoticed) {
  const Flow flow = flow_with(kFlippedImage);
  EXPECT_GT(flow.cell().ratio_to_bound, 10);
  EXPECT_GT(mean_reprojection_px(flow), 5);
  EXPECT_EQ(verdict_of(gate(flow), "geodesic_deg.mean"), Verdict::kWorse);
}

TEST_F(Audit, AFlippedCameraIsNoticed) {
  const Flow flow = flow_with(kFlippedCamera);
  EXPECT_EQ(flow.cell().geodesic_deg.capped, kTrials);
  EXPECT_TRUE(std::isinf(mean_reprojection_px(flow))) << "the target is behind the camera";
  const Comparison comparison = gate(flow);
  EXPECT_EQ(verdict_of(comparison, "geodesic_deg.mean"), Verdict::kWorse);
  EXPECT_EQ(verdict_of(comparison, "t_error_percent.mean"), Verdict::kWorse);
}

TEST_F(Audit, HalfAPixelIsNoticedByTheCoveragesOfTheCovariances) {
  // The translation takes it up: no residual grows and the angles hardly err, yet the covariances
  // no longer hold. Sideways a pose of 8 points is known to 0.5 px / sqrt(8), so that half a pixel
  // in u and v adds about 2 * 8 to the mean NEES of 6: its law is a non-central chi-squared one,
  // whose median lies less than one below its mean.
  const Flow flow = flow_with(kHalfAPixel);
  const NeesSummary nees = flow.cell().nees;
  EXPECT_GT(nees.median.ci95[0], 6 + 8 - 1);
  EXPECT_LT(nees.coverage95_ci95[1], 0.9);
}

TEST_F(Audit, MillimetresForMetresAreNoticed) {
  const Flow flow = flow_with(kMillimetres);
  EXPECT_EQ(flow.cell().t_error_percent.capped, kTrials);
  const Comparison comparison = gate(flow);
  EXPECT_EQ(verdict_of(comparison, "t_error_percent.mean"), Verdict::kWorse);
  EXPECT_EQ(verdict_of(comparison, "geodesic_deg.mean"), Verdict::kUnchanged);
}

TEST_F(Audit, ATransposedRotationIsNoticed) {
  const Flow flow = flow_with(kTransposed);
  EXPECT_GT(flow.cell().ratio_to_bound, 10);
  const Comparison comparison = gate(flow);
  EXPECT_EQ(verdict_of(comparison, "geodesic_deg.mean"), Verdict::kWorse);
  EXPECT_EQ(verdict_of(comparison, "t_error_percent.mean"), Verdict::kUnchanged);
}

TEST_F(Audit, ASolverThatReturnsItsStartIsNoticed) {
  const Flow flow = flow_with(kItsStart);
  for (const TrialRecord& trial : flow.trials) {
    EXPECT_DOUBLE_EQ(trial.estimates()[0].geodesic_deg,
                     geodesic_angle_rad(trial.pose_trial().prior_cam_from_target.rotation,
                                        trial.true_cam_from_target.rotation) /
                         kRadPerDeg);
  }
  EXPECT_GT(flow.cell().ratio_to_bound_median.ci95[0], 5);
  const Comparison comparison = gate(flow);
  EXPECT_EQ(verdict_of(comparison, "geodesic_deg.mean"), Verdict::kWorse);
  EXPECT_EQ(verdict_of(comparison, "t_error_percent.mean"), Verdict::kWorse);
}

TEST_F(Audit, AnIgnoredSeedIsNoticed) {
  Flow flow = flow_with(kSound);
  for (int i = 0; i < kTrials; ++i) {
    flow.trials[i] = run_numeric_trial(flow.study, 0);
    flow.trials[i].trial = i;
  }
  const Summary summary = flow.summary();
  EXPECT_EQ(summary.observations[0].repeated, kTrials - 1);
  EXPECT_EQ(summary.cells[0].geodesic_deg.mean_ci95[0], summary.cells[0].geodesic_deg.mean_ci95[1]);
  EXPECT_THAT(to_table(flow.study, summary),
              HasSubstr("warning: 99 of 100 trials are an earlier one again"));
  EXPECT_THAT(render_report({flow.study, summary, {}, {}, {}}),
              HasSubstr("Warning:</strong> 99 of 100 trials are an earlier one again"));
  EXPECT_THAT(render_report({flow.study, flow_with(kSound).summary(), {}, {}, {}}),
              Not(HasSubstr("class=\"warning\"")));
  EXPECT_THAT(to_json(flow.study, summary), HasSubstr("\"trials_repeated\": 99"));
  EXPECT_THAT(gate(flow).how, HasSubstr("not paired"));
}

TEST_F(Audit, AShardsSeedThatIsIgnoredIsNoticed) {
  // Two shards that both draw what the first should.
  Flow flow = flow_with(kSound);
  for (int i = 0; i < kTrials; ++i) {
    flow.trials[i] = run_numeric_trial(flow.study, i / 2);
    flow.trials[i].trial = i;
  }
  EXPECT_EQ(flow.observations().repeated, kTrials / 2);
}

// ---- Failures that are left out ----

// Some of its cubes reach behind the camera, in which every solver fails.
Flow failing_flow() {
  Flow flow = flow_of(cube_study({"poses.range_m=[0.4, 2]", "solver.start=free"}));
  const int failures = flow.cell().failures;
  EXPECT_TRUE(10 <= failures && failures <= 90) << failures;
  return flow;
}

TEST_F(Audit, AFailureWithoutAnEstimateCountsAllTheSame) {
  const Flow honest = failing_flow();
  Flow silent = honest;
  for (TrialRecord& trial : silent.trials) {
    std::erase_if(trial.pose_trial().estimates, [](const EstimateRecord& e) { return !e.is_ok(); });
  }
  EXPECT_EQ(to_json(silent.study, silent.summary()), to_json(honest.study, honest.summary()));
}

TEST_F(Audit, TrialsDroppedForTheirFailureAreNoticed) {
  const Flow honest = failing_flow();
  Flow dropped = honest;
  std::erase_if(dropped.trials, [](const TrialRecord& t) { return !t.estimates()[0].is_ok(); });
  EXPECT_LT(dropped.cell().geodesic_deg.mean, honest.cell().geodesic_deg.mean_ci95[0]);
  const auto left = static_cast<int>(dropped.trials.size());
  EXPECT_THAT(to_table(dropped.study, dropped.summary()),
              HasSubstr(fmt::format("{} of 100 trials", left)));
  EXPECT_THAT(to_table(honest.study, honest.summary()), HasSubstr("\n100 trials"));

  const fs::path base = write("honest", honest);
  const fs::path without = write("dropped", dropped);
  EXPECT_THAT(error_of([&] { compare_runs(base, without, 0); }), HasSubstr("lacks trial"));
  EXPECT_THAT(compare_runs(base, base, 0).how, Not(HasSubstr("left out")));
}

TEST_F(Audit, MergeRefusesAShardThatLacksATrial) {
  const std::string path = folder_.path().string();
  for (const char* shard : {"0", "1"}) {
    const Outcome outcome = run(fmt::format(
        "study cube-outliers --quiet --trials 5 --set 'solvers=[\"lspe\"]' --shard {0}/2 --out "
        "{1}/{0}",
        shard, path));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  }
  const std::string merge = fmt::format("merge {0}/0 {0}/1 --out {0}/", path);
  const Outcome whole = run(merge + "whole");
  EXPECT_EQ(whole.exit_code, 0) << whole.output;
  SQLite::Database store(path + "/1/results.sqlite", SQLite::OPEN_READWRITE);
  for (const char* table : {"observations", "estimates", "orientations", "trials"}) {
    store.exec(fmt::format("DELETE FROM {} WHERE trial = 7", table));
  }
  const Outcome outcome = run(merge + "part");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_THAT(outcome.output,
              HasSubstr("/1: lacks trial 7; must hold every trial of shard 1 of 2"));
  EXPECT_FALSE(fs::exists(path + "/part/report.html"));
}

// ---- The flow with images ----

class ImageAudit : public testing::Test {
 protected:
  ImageAudit() {
    study_ = read_study("boeing-random", {.trials = 5, .seed = {}, .set = {"solvers=['lspe']"}});
    for (int64_t i = 0; i < study_.trial_count(); ++i) {
      trials_.push_back(run_trial(study_, i, renderer_));
    }
  }

  // The trials with something done to their images on the way to the extractors.
  template <typename Fault>
  std::vector<TrialRecord> records_with(const Fault& fault) {
    std::vector<TrialRecord> records;
    for (Trial trial : trials_) {
      trial.frame.image = fault(trial);
      extract_and_solve(*study_.images(), study_.seed, trial, renderer_);
      records.push_back(trial.record);
    }
    return records;
  }

  std::vector<TrialRecord> sound() {
    return records_with([](const Trial& trial) { return trial.frame.image; });
  }

  Renderer renderer_;
  Study study_;
  std::vector<Trial> trials_;
};

Localisation localisation_of(const std::vector<TrialRecord>& trials) {
  LocalisationStatistics statistics;
  for (const TrialRecord& trial : trials) statistics.add(trial);
  return statistics.summary();
}

TEST_F(ImageAudit, HalfAPixelIsABias) {
  const Localisation before = localisation_of(sound());
  const Localisation after = localisation_of(records_with([](const Trial& trial) {
    const cv::Matx23d shift(1, 0, 0.5, 0, 1, 0.5);
    cv::Mat image;
    cv::warpAffine(trial.frame.image, image, shift, trial.frame.image.size(), cv::INTER_LINEAR,
                   cv::BORDER_REPLICATE);
    return image;
  }));
  // Which features are inliers may change a little, and with them the mean.
  constexpr double kTolerancePx = 0.2;
  EXPECT_NEAR(after.bias_u_px.value - before.bias_u_px.value, 0.5, kTolerancePx);
  EXPECT_NEAR(after.bias_v_px.value - before.bias_v_px.value, 0.5, kTolerancePx);
}

TEST_F(ImageAudit, ABlankFrameIsOneOfFailures) {
  const std::vector<TrialRecord> seen = sound();
  EXPECT_GT(localisation_of(seen).found_rate.value, 0.7);
  EXPECT_EQ(summarise(study_, seen).cells[0].failures, 0);

  // A corner of the image, which holds background and noise alone, everywhere.
  const std::vector<TrialRecord> blank = records_with([](const Trial& trial) {
    const cv::Rect corner(0, 0, 64, 64);
    EXPECT_EQ(cv::countNonZero(trial.frame.body_ids(corner)), 0);
    return cv::repeat(trial.frame.image(corner), 8, 8);
  });
  const Localisation none = localisation_of(blank);
  EXPECT_GT(none.visible, 0);
  EXPECT_EQ(none.found, 0);
  EXPECT_EQ(none.labels.at(ObservationLabel::kMissing), none.visible);
  for (const TrialRecord& trial : blank) {
    for (const ObservationRecord& o : trial.observations()) EXPECT_FALSE(o.is_found());
    EXPECT_EQ(trial.estimates()[0].status, EstimateOutcome::kTooFewPoints);
  }
  const Summary summary = summarise(study_, blank);
  EXPECT_EQ(summary.cells[0].failures, 5);
  EXPECT_EQ(summary.cells[0].geodesic_deg.mean, kAngleCapDeg);
  EXPECT_THAT(to_table(study_, summary), HasSubstr("failed: lspe 5 of 5"));
}

// ---- Image sets ----

class SetAudit : public testing::Test {
 protected:
  SetAudit() {
    const Outcome outcome = run(
        "render cube --quiet --count 2 --set camera.width_px=64 --set camera.height_px=64 --set "
        "camera.f_px=250 --set image.samples_per_pixel=1 --out " +
        set());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  }
  std::string set() const { return (folder_.path() / "set").string(); }

  // What the verification says once the list of numbers under a key of the first pose is another.
  template <typename Change>
  Outcome verified_with(const std::string& key, const Change& change) const {
    const std::string file = "set/test/000000/scene_gt.json";
    const std::string before = read_whole(folder_.path() / file);
    const size_t begin = before.find('[', before.find("\"" + key + "\""));
    const size_t size = before.find(']', begin) + 1 - begin;
    auto numbers = nlohmann::json::parse(before.substr(begin, size)).get<std::vector<double>>();
    change(numbers);
    std::string after = before;
    after.replace(begin, size, nlohmann::json(numbers).dump());
    folder_.write(file, after);
    const Outcome outcome = run("render --quiet --verify " + set());
    folder_.write(file, before);
    return outcome;
  }

  TemporaryFolder folder_;
};

TEST_F(SetAudit, AFaultInTheStatedPoseIsNoticed) {
  const auto nothing = [](std::vector<double>&) {};
  const auto metres = [](std::vector<double>& t) {
    for (double& mm : t) mm /= 1000;
  };
  const auto flipped = [](std::vector<double>& t) { t[1] = -t[1]; };
  const auto transposed = [](std::vector<double>& r) {
    std::swap(r[1], r[3]);
    std::swap(r[2], r[6]);
    std::swap(r[5], r[7]);
  };
  for (const char* key : {"cam_t_m2c", "cam_R_m2c"}) {
    const Outcome sound = verified_with(key, nothing);
    EXPECT_EQ(sound.exit_code, 0) << sound.output;
  }
  for (const Outcome& outcome :
       {verified_with("cam_t_m2c", metres), verified_with("cam_t_m2c", flipped),
        verified_with("cam_R_m2c", transposed)}) {
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.output, HasSubstr("scene_gt.json"));
  }
}

}  // namespace
}  // namespace sightline
