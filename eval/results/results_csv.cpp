// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/results/results_csv.h"

#include <array>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/csv.h"

namespace sightline {
namespace {

CsvLine& operator<<(CsvLine& line, const Pose& pose) {
  for (const double q : quaternion_wxyz(pose.rotation)) line << q;
  for (const double t : pose.translation) line << t;
  return line;
}

using Names = std::span<const std::string_view>;

constexpr std::array<std::string_view, 2> kTrial{"trial", "condition"};
// Of a trial whose image is a data set's.
constexpr std::array<std::string_view, 4> kSighting{"image", "scene_id", "im_id", "gt_id"};
constexpr std::array<std::string_view, 2> kSolver{"solver", "status"};
constexpr std::array<std::string_view, 8> kErrors{
    "theta_error_deg", "t_error_percent", "geodesic_deg", "reprojection_rms_px",
    "add_m",           "mssd_m",          "mspd_px",      "nees"};
constexpr std::array<std::string_view, 5> kCounts{"removed", "false_removals", "missed_outliers",
                                                  "found", "outliers"};
constexpr std::array<std::string_view, 7> kPose{"qw", "qx", "qy", "qz", "tx_m", "ty_m", "tz_m"};
constexpr std::array<std::string_view, 6> kOrientation{
    "copies", "failures", "angle_error_deg", "theta_error_deg", "geodesic_deg", "t_error_percent"};
constexpr std::array<std::string_view, 2> kTiming{"solver", "time_ns"};
constexpr std::array<std::string_view, 7> kTruePose{"true_qw",   "true_qx",   "true_qy",  "true_qz",
                                                    "true_tx_m", "true_ty_m", "true_tz_m"};

std::set<std::string> condition_keys(const Study& study) {
  std::set<std::string> keys;
  for (const Condition& condition : study.conditions) {
    for (const auto& [key, value] : condition.values) keys.insert(key);
    for (const auto& [key, word] : condition.words) keys.insert(key);
  }
  return keys;
}

std::string header(const std::set<std::string>& keys, std::initializer_list<Names> columns) {
  CsvLine line;
  const auto add = [&line](const auto& names) {
    for (const auto& name : names) line << name;
  };
  add(kTrial);
  add(keys);
  for (const Names names : columns) add(names);
  return std::move(line).end();
}

// What a trial's images gave.
struct Counts {
  int found = 0;
  int outliers = 0;
};

Counts count_observations(const TrialRecord& trial) {
  Counts counts;
  for (const ObservationRecord& observation : trial.observations) {
    counts.found += observation.is_found();
    counts.outliers += observation.is_outlier;
  }
  return counts;
}

void write_errors(CsvLine& line, const EstimateRecord& e) {
  if (!e.is_ok()) {
    line.empty_fields(kErrors.size());
    return;
  }
  line << e.theta_error_deg << e.t_error_percent << e.geodesic_deg << e.reprojection_rms_px
       << e.add_m << e.mssd_m << e.mspd_px;
  e.covariance ? line << e.nees : line << "";
}

void write_removals(CsvLine& line, const EstimateRecord& e, const Counts& counts) {
  if (!e.is_ok()) {
    line << "" << 0 << counts.outliers;
    return;
  }
  line << fmt::format("{}", fmt::join(e.removed, ";")) << e.false_removals << e.missed_outliers;
}

void write_condition(CsvLine& line, const Condition& condition, const std::set<std::string>& keys,
                     const TrialRecord& trial) {
  line << trial.trial << condition.label;
  for (const std::string& key : keys) {
    const auto value = condition.values.find(key);
    const auto word = condition.words.find(key);
    if (value != condition.values.end()) {
      line << value->second;
    } else {
      line << (word != condition.words.end() ? word->second : "");
    }
  }
}

void write_sighting(CsvLine& line, const Sighting& sighting) {
  line << sighting.image << sighting.scene_id << sighting.im_id << sighting.gt_id;
}

void write_estimate(CsvLine& line, const TrialRecord& trial, const Counts& counts,
                    const EstimateRecord& estimate) {
  line << estimate.solver << estimate.status;
  write_errors(line, estimate);
  write_removals(line, estimate, counts);
  line << counts.found << counts.outliers;
  estimate.is_ok() ? line << estimate.cam_from_target : line.empty_fields(kPose.size());
  line << trial.true_cam_from_target;
}

void write_orientation(CsvLine& line, const OrientationStudy& study, const TrialRecord& trial,
                       const OrientationRecord& orientation) {
  line << orientation.method << orientation.status << study.pairs.copies << orientation.failures
       << orientation.angle_error_deg << orientation.theta_error_deg << orientation.geodesic_deg
       << orientation.t_error_percent << trial.true_cam_from_target;
}

void write_orientation_csv(const Study& study, const OrientationStudy& of_kind,
                           const TrialSource& trials, std::ostream& out) {
  const std::set<std::string> keys = condition_keys(study);
  out << header(keys, {kSolver, kOrientation, kTruePose});
  trials([&](const TrialRecord& trial) {
    for (const OrientationRecord& orientation : trial.orientations) {
      CsvLine line;
      write_condition(line, study.conditions[trial.condition], keys, trial);
      write_orientation(line, of_kind, trial, orientation);
      out << std::move(line).end();
    }
  });
}

}  // namespace

void write_csv(const Study& study, const TrialSource& trials, std::ostream& out) {
  if (const OrientationStudy* const orientation = study.orientation()) {
    return write_orientation_csv(study, *orientation, trials, out);
  }
  const ImageStudy* const images = study.images();
  const bool is_sighted = images != nullptr && images->sighted;
  const std::set<std::string> keys = condition_keys(study);
  const Names sighting_columns = is_sighted ? Names(kSighting) : Names();
  out << header(keys, {sighting_columns, kSolver, kErrors, kCounts, kPose, kTruePose});
  trials([&](const TrialRecord& trial) {
    const Counts counts = count_observations(trial);
    for (const EstimateRecord& estimate : trial.estimates) {
      CsvLine line;
      write_condition(line, study.conditions[trial.condition], keys, trial);
      if (is_sighted) write_sighting(line, images->sighting_of(trial.trial));
      write_estimate(line, trial, counts, estimate);
      out << std::move(line).end();
    }
  });
}

void write_timings_csv(const Study& study, const TrialSource& trials, std::ostream& out) {
  const std::set<std::string> keys = condition_keys(study);
  out << header(keys, {kTiming});
  trials([&](const TrialRecord& trial) {
    for (const OrientationRecord& orientation : trial.orientations) {
      CsvLine line;
      write_condition(line, study.conditions[trial.condition], keys, trial);
      line << orientation.method << orientation.time_ns;
      out << std::move(line).end();
    }
  });
}

}  // namespace sightline
