// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "eval/records/records.h"
#include "eval/study/study.h"
#include "eval/summary/summary.h"
#include "tests/eval/studies.h"

namespace sightline::handmade {

/// A study of images with two poses and three solvers, whose trials' features are not its target's.
inline Study two_poses() {
  Study study;
  study.name = "tiny";
  study.seed = 7;
  study.draws = 3;
  study.conditions = {{"pose 1", {{"pose", 1}, {"noise_px", 0.5}}, {}},
                      {"pose 2", {{"pose", 2}, {"noise_px", 2.0}}, {}}};
  for (const char* name : {"orpe", "lspe", "oracle"}) {
    images_of(study).solving.solvers.push_back(built_in(*find_pose_solver(name)));
  }
  images_of(study).target = load_target("cube");
  images_of(study).setups.emplace_back();
  images_of(study).cells.resize(2);
  return study;
}

/// A feature that was found `error` px from its true place; the errors are of 0.5 px.
inline ObservationRecord corner_off_by(const Eigen::Vector2d& error, bool is_outlier = false) {
  ObservationRecord o;
  o.feature = "corner";
  o.status = ObservationOutcome::kFound;
  o.label = is_outlier ? ObservationLabel::kWrongLine : ObservationLabel::kInlier;
  o.is_visible = true;
  o.pixel = error;
  o.error_px = error.norm();
  o.error_sigmas = error.norm() / 0.5;
  o.is_outlier = is_outlier;
  return o;
}

inline ObservationRecord corner_missing() {
  ObservationRecord o;
  o.feature = "corner";
  o.status = ObservationOutcome::kNoCorner;
  o.label = ObservationLabel::kMissing;
  o.is_visible = true;
  return o;
}

inline ObservationRecord found(const char* feature, double error_px, bool is_outlier = false) {
  ObservationRecord observation;
  observation.feature = feature;
  observation.status = ObservationOutcome::kFound;
  observation.is_visible = true;
  observation.error_px = error_px;
  observation.is_outlier = is_outlier;
  return observation;
}

inline ObservationRecord hidden(const char* feature) {
  ObservationRecord observation;
  observation.feature = feature;
  observation.status = ObservationOutcome::kHidden;
  return observation;
}

inline EstimateRecord estimate(const char* solver, double geodesic_deg, int false_removals = 0,
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
inline EstimateRecord failed(const char* solver, EstimateOutcome reason) {
  EstimateRecord record = estimate(solver, 0.25, 7, 9);
  record.status = reason;
  record.removed = {"nonsense"};
  return record;
}

// Three trials of pose 1, small enough to work out by hand; one of pose 2, which nothing came of.
inline std::vector<TrialRecord> handmade_trials() {
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

inline const CellSummary& cell_of(const Summary& summary, int condition,
                                  const std::string& solver) {
  return *std::find_if(summary.cells.begin(), summary.cells.end(), [&](const CellSummary& c) {
    return c.condition == condition && c.solver == solver;
  });
}

}  // namespace sightline::handmade
