// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A small made-up study with its trials, summary and frames: what the tests of the report judge.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "eval/report/evidence.h"
#include "eval/report/frame_svg.h"
#include "eval/report/page_text.h"
#include "eval/report/report.h"
#include "tests/eval/studies.h"

namespace sightline::small_report {

inline constexpr int kSide = 64;
/// A feature whose name would break a page that forgets to escape.
inline constexpr const char* kEvilName = "tip <b>&\"quoted\"";

inline Mesh one_triangle() {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.parts = {{"plate", 0.8}};
  const Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  mesh.triangles = {{{0, 1, 2}, 0, {normal, normal, normal}}};
  return mesh;
}

inline std::shared_ptr<const Target> small_target() {
  const Mesh mesh = one_triangle();
  std::vector<TargetFeature> features(4);
  const char* names[] = {kEvilName, "root", "fin", "nose"};
  for (size_t i = 0; i < features.size(); ++i) {
    features[i].name = names[i];
    features[i].parts = {"plate"};
  }
  std::vector<FeatureShape> shapes = feature_shapes(mesh, features);
  return std::make_shared<Target>(Target{
      "plate", "one triangle", mesh, {}, std::move(features), Occluder(mesh), std::move(shapes)});
}

inline Study small_study() {
  Study study;
  study.name = "small";
  study.title = "A small study of <plates>";
  study.question = "Is 1 < 2 & 2 > 1?";
  study.draws = 2;
  study.conditions = {{"pose 1", {{"pose", 1}}, {{"orpe", {2.07, 1.6}}}},
                      {"pose 2", {{"pose", 2}}, {{"orpe", {3.07, 2.6}}}}};
  ImageStudy& images = images_of(study);
  images.cells = {{.setup = 0, .pose = 0}, {.setup = 0, .pose = 1}};
  images.target = small_target();
  images.features = {0, 1, 2, 3};
  ImageSetup& setup = images.setups.emplace_back();
  setup.scene.poses.theta_deg = {{-20, 30, 40}, {20, 30, 30}};
  setup.scene.poses.t_m = {{-5, 5, 1300}, {5, 5, 1500}};
  setup.scene.camera = centred_camera(kSide, kSide, 1000);
  setup.extractors = {find_feature_extractor("hough_intersection"),
                      find_feature_extractor("shi_tomasi_nearest")};
  images.solving.solvers = {built_in(*find_pose_solver("orpe")),
                            built_in(*find_pose_solver("lspe")),
                            built_in(*find_pose_solver("oracle"))};
  study.toml = "# </code><script>alert(1)</script>\nseed = 1\n";
  return study;
}

inline ObservationRecord found(const std::string& name, const Eigen::Vector2d& pixel,
                               double error_px, bool is_outlier = false) {
  ObservationRecord record;
  record.feature = name;
  record.status = ObservationOutcome::kFound;
  record.is_visible = true;
  record.pixel = pixel;
  record.true_pixel = pixel - Eigen::Vector2d(error_px, 0);
  record.error_px = error_px;
  record.is_outlier = is_outlier;
  return record;
}

inline ObservationRecord missing(const std::string& name, ObservationStatus status) {
  ObservationRecord record;
  record.feature = name;
  record.status = from_string<ObservationOutcome>(to_string(status));
  return record;
}

inline EstimateRecord estimate(const std::string& solver, double theta_error_deg,
                               EstimateOutcome status = EstimateOutcome::kOk) {
  EstimateRecord record;
  record.solver = solver;
  record.status = status;
  record.theta_error_deg = theta_error_deg;
  record.t_error_percent = theta_error_deg / 2;
  return record;
}

inline TrialRecord small_trial(int64_t index, double orpe_error_deg) {
  TrialRecord trial;
  trial.trial = index;
  trial.condition = static_cast<int>(index % 2);
  trial.true_cam_from_target.translation = {0, 0, 1300};
  trial.pose_trial().observations = {
      found(kEvilName, {20, 20}, 0.4), found("root", {40, 22}, 9.5, true),
      missing("fin", ObservationStatus::kTooFewEdgePixels), found("nose", {30, 45}, 0.2)};
  trial.pose_trial().estimates = {estimate("orpe", orpe_error_deg),
                                  estimate("lspe", orpe_error_deg + 1), estimate("oracle", 0.1)};
  trial.pose_trial().estimates[0].removed = {"root"};
  trial.pose_trial().estimates[0].is_test_failed = false;
  return trial;
}

inline Observation observed(int feature, const cv::Rect& window) {
  Observation observation;
  observation.feature = feature;
  observation.window = window;
  ImageLine line;
  line.point = {window.x + 5.0, window.y + 5.0};
  line.direction = Eigen::Vector2d(3, 4) / 5;
  line.edge_pixels = {line.point, line.point + Eigen::Vector2d(3, 4)};
  observation.lines = {line};
  return observation;
}

inline FrameEvidence small_frame(const TrialRecord& record) {
  FrameEvidence frame;
  frame.caption = "pose 1, draw 1; worst of ORPE";
  frame.stored = record;
  frame.trial.record = record;
  cv::Mat image(kSide, kSide, CV_8U, cv::Scalar(40));
  image(cv::Rect(16, 16, 24, 24)) = 200;
  frame.picture = picture_of(image, 8, {});
  frame.trial.observations = {observed(0, {12, 12, 17, 17}), observed(1, {32, 14, 17, 17}),
                              observed(2, {12, 40, 17, 17}), observed(3, {22, 37, 17, 17})};
  frame.outlines["orpe"] = {{{15.5, 15.5}, {39.5, 15.5}, {39.5, 39.5}, {15.5, 39.5}}};
  return frame;
}

inline ErrorSummary error_summary(double mean) {
  ErrorSummary summary;
  summary.mean = mean;
  summary.mean_ci95 = {mean - 0.3, mean + 0.4};
  summary.median = mean - 0.05;
  return summary;
}

inline Summary small_summary() {
  Summary summary;
  for (int condition = 0; condition < 2; ++condition) {
    for (const char* solver : {"orpe", "lspe", "oracle"}) {
      CellSummary cell;
      cell.condition = condition;
      cell.solver = solver;
      cell.trials = 2;
      cell.failures = condition;
      cell.theta_error_deg = error_summary(1.25 + condition);
      cell.t_error_percent = error_summary(0.75);
      cell.ratio_to_bound = std::numeric_limits<double>::quiet_NaN();
      summary.cells.push_back(cell);
    }
    CellObservations observations;
    observations.condition = condition;
    observations.trials = 2;
    observations.inlier_rms_px = 0.31;
    observations.bound_theta_deg = 0.123;
    observations.bound_t_percent = 0.0456;
    observations.outliers = 1;
    summary.observations.push_back(observations);
    for (const char* feature : {kEvilName, "root", "fin", "nose"}) {
      summary.features.push_back({condition, feature, 2, 2, 0, 0.3, 0.25});
    }
  }
  return summary;
}

/// Lines joined by one blank, for they may break wherever a page has a space.
inline std::string one_line(const std::string& text) {
  return std::regex_replace(text, std::regex(R"([ \n]+)"), " ");
}

/// A report of everything, held together.
struct SmallReport {
  Study study = small_study();
  Summary summary = small_summary();
  std::vector<TrialRecord> trials = {small_trial(0, 1), small_trial(1, 5), small_trial(2, 2),
                                     small_trial(3, 3)};
  std::vector<FrameEvidence> frames = {small_frame(trials[0])};

  ReportInput input() const {
    shown_ = summary;
    if (study.pose_study() != nullptr) {
      shown_.extraction.emplace(study);
      for (const TrialRecord& trial : trials) shown_.extraction->add(trial);
    }
    return {study, shown_, trials, frames, {{"version", "0.1.0"}, {"machine", "two <cores>"}}};
  }
  // Without Chart.js, which is not ours to judge.
  std::string page() const {
    std::string text = render_report(input());
    const std::string library = page_text("chart.js");
    const size_t at = text.find(library);
    if (at == std::string::npos) return "a page without Chart.js";
    return one_line(text.erase(at, library.size()));
  }

 private:
  mutable Summary shown_;  // the summary and what the trials say of the features
};

inline size_t count(const std::string& text, const std::string& part) {
  size_t times = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++times;
  return times;
}

/// Whether a page has a part; HasSubstr would print the whole page.
inline ::testing::AssertionResult has(const std::string& page, const std::string& part) {
  const bool is_there = page.find(part) != std::string::npos;
  return (is_there ? ::testing::AssertionSuccess() : ::testing::AssertionFailure())
         << "the page " << (is_there ? "has " : "lacks ") << part;
}

/// As of a shard that has no trial of pose 1.
inline SmallReport report_of_pose_2() {
  SmallReport report;
  for (CellSummary& cell : report.summary.cells) {
    if (cell.condition != 0) continue;
    CellSummary empty;
    empty.solver = cell.solver;
    cell = empty;
  }
  report.summary.observations[0] = {};
  std::erase_if(report.trials, [](const TrialRecord& trial) { return trial.condition == 0; });
  return report;
}

}  // namespace sightline::small_report
