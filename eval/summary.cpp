// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pose/bounds.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;
using Trials = std::vector<const TrialRecord*>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr std::string_view kOracle = "oracle";
// Stands for the noise of a feature that showed none, so that its information is finite.
constexpr double kLeastNoisePx = 1e-3;

// A sum of squares that knows how many it holds.
struct MeanSquare {
  double sum = 0;
  int count = 0;

  void add(double value) {
    sum += value * value;
    ++count;
  }
  double root() const { return count > 0 ? std::sqrt(sum / count) : kNoNumber; }
};

double ratio(double a, double b) {
  return b > 0 ? a / b : kNoNumber;
}

// The trials of a condition by their number, so that sums do not depend on the order of shards.
Trials trials_of(std::span<const TrialRecord> trials, int condition) {
  Trials chosen;
  for (const TrialRecord& trial : trials) {
    if (trial.condition == condition) chosen.push_back(&trial);
  }
  std::sort(chosen.begin(), chosen.end(),
            [](const TrialRecord* a, const TrialRecord* b) { return a->trial < b->trial; });
  return chosen;
}

int outliers_in(const TrialRecord& trial) {
  return static_cast<int>(std::count_if(trial.observations.begin(), trial.observations.end(),
                                        [](const ObservationRecord& o) { return o.is_outlier; }));
}

// The solver's pose of a trial; null when it failed or is not there.
const EstimateRecord* pose_of(const TrialRecord& trial, std::string_view solver) {
  const EstimateRecord* const estimate = find_estimate(trial, solver);
  return estimate != nullptr && estimate->is_ok() ? estimate : nullptr;
}

// The found inliers' error in one coordinate, when a feature's name is given of that feature alone.
MeanSquare inlier_error(const Trials& trials, const std::string* feature = nullptr) {
  MeanSquare error;
  for (const TrialRecord* trial : trials) {
    for (const ObservationRecord& o : trial->observations) {
      if (feature != nullptr && o.feature != *feature) continue;
      if (o.is_found() && !o.is_outlier) error.add(o.error_px / std::sqrt(2.0));
    }
  }
  return error;
}

CellObservations summarise_observations(const Trials& trials, int condition) {
  CellObservations cell;
  cell.condition = condition;
  cell.trials = static_cast<int>(trials.size());
  cell.inlier_rms_px = inlier_error(trials).root();
  int found = 0;
  int outliers = 0;
  for (const TrialRecord* trial : trials) {
    for (const ObservationRecord& o : trial->observations) found += o.is_found();
    outliers += outliers_in(*trial);
  }
  if (cell.trials > 0) {
    cell.found = static_cast<double>(found) / cell.trials;
    cell.outliers = static_cast<double>(outliers) / cell.trials;
  }
  return cell;
}

// Every trial that was imaged has an observation of every feature, in the study's order.
std::vector<std::string> features_in(const Trials& trials) {
  std::vector<std::string> features;
  for (const TrialRecord* trial : trials) {
    for (const ObservationRecord& o : trial->observations) {
      const bool is_known =
          std::find(features.begin(), features.end(), o.feature) != features.end();
      if (!is_known) features.push_back(o.feature);
    }
  }
  return features;
}

FeatureSummary summarise_feature(const Trials& trials, int condition, const std::string& feature) {
  FeatureSummary summary;
  summary.condition = condition;
  summary.feature = feature;
  std::vector<double> errors_px;
  for (const TrialRecord* trial : trials) {
    for (const ObservationRecord& o : trial->observations) {
      if (o.feature != feature) continue;
      summary.visible += o.is_visible;
      summary.outliers += o.is_outlier;
      if (o.is_found()) errors_px.push_back(o.error_px);
    }
  }
  summary.found = static_cast<int>(errors_px.size());
  summary.inlier_rms_px = inlier_error(trials, &feature).root();
  summary.median_px = percentile(errors_px, 0.5);
  return summary;
}

// The bound of one trial, in the units of errors and capped like them.
struct TrialBound {
  double theta_deg = 0;
  double t_percent = 0;
  double geodesic_deg = 0;
};

// Where the target has its features, by name; empty for a study without a target.
using Positions = std::map<std::string, Eigen::Vector3d>;

Positions positions_of(const Study& study) {
  Positions positions;
  if (study.target == nullptr) return positions;
  for (const TargetFeature& feature : study.target->features) {
    positions.emplace(feature.name, feature.position_m);
  }
  return positions;
}

// None for a trial whose inliers do not determine a pose. A feature that the target does not have
// (any more: stored trials outlive the target's file) tells nothing.
std::optional<TrialBound> bound_of(const Study& study, const Positions& positions,
                                   const TrialRecord& trial,
                                   const std::map<std::string, double>& noise_px) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Matrix2d> covariances_px2;
  for (const ObservationRecord& o : trial.observations) {
    const auto position = positions.find(o.feature);
    if (!o.is_found() || o.is_outlier || position == positions.end()) continue;
    points.push_back(position->second);
    const double sd_px = std::max(noise_px.at(o.feature), kLeastNoisePx);
    covariances_px2.push_back(sd_px * sd_px * Eigen::Matrix2d::Identity());
  }
  const auto bound = cramer_rao_bound(study.camera_of(trial.condition), points,
                                      trial.true_cam_from_target, covariances_px2);
  if (!bound) return std::nullopt;
  constexpr double kDegree = std::numbers::pi / 180;
  return TrialBound{std::min(bound->attitude_rms_rad / kDegree, kAngleCapDeg),
                    std::min(100 * bound->translation_rms, kTranslationCapPercent),
                    std::min(bound->geodesic_rms_rad / kDegree, kAngleCapDeg)};
}

// A numeric study's cell without noise has no bound, and exact solvers err by rounding alone, of
// which ratios say nothing.
bool is_noiseless(const Study& study, int condition) {
  return study.kind == StudyKind::kNumeric && study.conditions[condition].noise_sd == 0;
}

// By trial.
std::vector<std::optional<TrialBound>> bounds_of(const Study& study, const Positions& positions,
                                                 const Trials& trials, int condition,
                                                 std::span<const FeatureSummary> features) {
  std::vector<std::optional<TrialBound>> bounds(trials.size());
  if (is_noiseless(study, condition)) return bounds;
  std::map<std::string, double> noise_px;
  for (const FeatureSummary& feature : features) {
    noise_px[feature.feature] = study.kind == StudyKind::kNumeric
                                    ? study.conditions[condition].noise_sd
                                    : feature.inlier_rms_px;
  }
  for (size_t i = 0; i < trials.size(); ++i) {
    bounds[i] = bound_of(study, positions, *trials[i], noise_px);
  }
  return bounds;
}

void set_bounds(const std::vector<std::optional<TrialBound>>& bounds, CellObservations& cell) {
  double theta_deg = 0;
  double t_percent = 0;
  MeanSquare geodesic_deg;
  for (const auto& bound : bounds) {
    if (!bound) continue;
    theta_deg += bound->theta_deg;
    t_percent += bound->t_percent;
    geodesic_deg.add(bound->geodesic_deg);
  }
  const int count = geodesic_deg.count;
  cell.bound_theta_deg = count > 0 ? theta_deg / count : kNoNumber;
  cell.bound_t_percent = count > 0 ? t_percent / count : kNoNumber;
  cell.bound_geodesic_deg = geodesic_deg.root();
}

// A solver's errors in the order of the trials, infinite where it failed.
std::vector<double> errors_of(const Trials& trials, std::string_view solver,
                              double EstimateRecord::*error) {
  std::vector<double> errors;
  for (const TrialRecord* trial : trials) {
    const EstimateRecord* const estimate = pose_of(*trial, solver);
    errors.push_back(estimate != nullptr ? estimate->*error : kInfinity);
  }
  return errors;
}

void count_removals(const Trials& trials, CellSummary& cell) {
  int exact = 0;
  cell.false_removals = 0;
  cell.missed_outliers = 0;
  for (const TrialRecord* trial : trials) {
    const EstimateRecord* const estimate = pose_of(*trial, cell.solver);
    if (estimate == nullptr) {
      ++cell.failures;
      cell.missed_outliers += outliers_in(*trial);
      continue;
    }
    cell.false_removals += estimate->false_removals;
    cell.missed_outliers += estimate->missed_outliers;
    exact += estimate->false_removals == 0 && estimate->missed_outliers == 0;
  }
  cell.false_removals /= cell.trials;
  cell.missed_outliers /= cell.trials;
  cell.exact_set_rate = static_cast<double>(exact) / cell.trials;
}

CellSummary summarise_cell(const Study& study, const Trials& trials, int condition,
                           std::string_view solver) {
  CellSummary cell;
  cell.condition = condition;
  cell.solver = solver;
  cell.trials = static_cast<int>(trials.size());
  const auto statistics = [&](double EstimateRecord::*error, double cap, std::string_view name) {
    const std::string stream =
        fmt::format("bootstrap/{}/{}/{}", study.conditions[condition].label, solver, name);
    return summarise(errors_of(trials, solver, error), cap, study.seed, stream);
  };
  cell.theta_error_deg =
      statistics(&EstimateRecord::theta_error_deg, kAngleCapDeg, "theta_error_deg");
  cell.t_error_percent =
      statistics(&EstimateRecord::t_error_percent, kTranslationCapPercent, "t_error_percent");
  cell.geodesic_deg = statistics(&EstimateRecord::geodesic_deg, kAngleCapDeg, "geodesic_deg");
  if (cell.trials > 0) count_removals(trials, cell);
  return cell;
}

// A solver's capped geodesic error, RMS over the trials that `counts` picks.
template <typename Predicate>
double rms_geodesic_deg(const Trials& trials, std::string_view solver, const Predicate& counts) {
  MeanSquare error;
  for (size_t i = 0; i < trials.size(); ++i) {
    if (!counts(i)) continue;
    const EstimateRecord* const estimate = pose_of(*trials[i], solver);
    error.add(estimate != nullptr ? std::min(estimate->geodesic_deg, kAngleCapDeg) : kAngleCapDeg);
  }
  return error.root();
}

void set_ratios(const Study& study, const Trials& trials,
                const std::vector<std::optional<TrialBound>>& bounds,
                const CellObservations& observations, CellSummary& cell) {
  if (is_noiseless(study, cell.condition)) return;
  const auto has_oracle = [&](size_t i) { return pose_of(*trials[i], kOracle) != nullptr; };
  const auto has_bound = [&](size_t i) { return bounds[i].has_value(); };
  cell.ratio_to_oracle = ratio(rms_geodesic_deg(trials, cell.solver, has_oracle),
                               rms_geodesic_deg(trials, kOracle, has_oracle));
  cell.ratio_to_bound =
      ratio(rms_geodesic_deg(trials, cell.solver, has_bound), observations.bound_geodesic_deg);
}

const OrientationRecord* find_orientation(const TrialRecord& trial, std::string_view method) {
  for (const OrientationRecord& orientation : trial.orientations) {
    if (orientation.method == method) return &orientation;
  }
  return nullptr;
}

CellSummary summarise_method(const Study& study, const Trials& trials, int condition,
                             const std::string& method) {
  CellSummary cell;
  cell.condition = condition;
  cell.solver = method;
  cell.trials = static_cast<int>(trials.size());
  std::vector<const OrientationRecord*> records;
  for (const TrialRecord* trial : trials) {
    if (const OrientationRecord* const record = find_orientation(*trial, method)) {
      records.push_back(record);
      cell.failures += record->failures > 0;
      cell.failed_copies += record->failures;
    }
  }
  const auto statistics = [&](double OrientationRecord::*member, double cap,
                              std::string_view name) {
    std::vector<double> values;
    for (const OrientationRecord* record : records) values.push_back(record->*member);
    return summarise(
        values, cap, study.seed,
        fmt::format("bootstrap/{}/{}/{}", study.conditions[condition].label, method, name));
  };
  using Record = OrientationRecord;
  cell.angle_error_deg = statistics(&Record::angle_error_deg, kAngleCapDeg, "angle_error_deg");
  cell.theta_error_deg = statistics(&Record::theta_error_deg, kAngleCapDeg, "theta_error_deg");
  cell.geodesic_deg = statistics(&Record::geodesic_deg, kAngleCapDeg, "geodesic_deg");
  cell.t_error_percent =
      statistics(&Record::t_error_percent, kTranslationCapPercent, "t_error_percent");
  if (study.pairs.timed_repeats > 0) {
    cell.time_ns = statistics(&Record::time_ns, kInfinity, "time_ns");
  }
  return cell;
}

Summary summarise_orientations(const Study& study, std::span<const TrialRecord> trials) {
  Summary summary;
  for (int condition = 0; condition < static_cast<int>(study.conditions.size()); ++condition) {
    const Trials of_cell = trials_of(trials, condition);
    for (const std::string& method : study.solver_names()) {
      summary.cells.push_back(summarise_method(study, of_cell, condition, method));
    }
    CellObservations& observations = summary.observations.emplace_back();
    observations.condition = condition;
    observations.trials = static_cast<int>(of_cell.size());
  }
  return summary;
}

// A key whose values are all whole numbers is a count or a number of a case, written as integers.
bool is_whole(const Study& study, const std::string& key) {
  return std::all_of(study.conditions.begin(), study.conditions.end(), [&](const Condition& c) {
    const auto value = c.values.find(key);
    return value == c.values.end() || value->second == std::floor(value->second);
  });
}

Json condition_json(const Study& study, int condition) {
  Json json = Json::object();
  for (const auto& [key, value] : study.conditions[condition].values) {
    if (is_whole(study, key)) {
      json[key] = static_cast<int64_t>(value);
    } else {
      json[key] = value;
    }
  }
  for (const auto& [key, word] : study.conditions[condition].words) json[key] = word;
  return json;
}

// The library writes numbers that are not finite as null.
Json error_json(const ErrorSummary& error) {
  return {{"mean", error.mean},
          {"mean_ci95", error.mean_ci95},
          {"median", error.median},
          {"rms", error.rms}};
}

Json cell_json(const Study& study, const CellSummary& cell) {
  Json json = {{"condition", condition_json(study, cell.condition)},
               {"solver", cell.solver},
               {"trials", cell.trials},
               {"failures", cell.failures},
               {"theta_error_deg", error_json(cell.theta_error_deg)},
               {"t_error_percent", error_json(cell.t_error_percent)},
               {"geodesic_deg", error_json(cell.geodesic_deg)},
               {"ratio_to_oracle", cell.ratio_to_oracle},
               {"ratio_to_bound", cell.ratio_to_bound},
               {"false_removals", cell.false_removals},
               {"missed_outliers", cell.missed_outliers},
               {"exact_set_rate", cell.exact_set_rate},
               {"capped", cell.geodesic_deg.capped}};
  if (study.kind == StudyKind::kOrientation) {
    json["copies"] = study.pairs.copies;
    json["failed_copies"] = cell.failed_copies;
    json["angle_error_deg"] = error_json(cell.angle_error_deg);
  }
  return json;
}

Json observations_json(const Study& study, const CellObservations& cell) {
  return {{"condition", condition_json(study, cell.condition)},
          {"trials", cell.trials},
          {"found_per_trial", cell.found},
          {"outliers_per_trial", cell.outliers},
          {"inlier_rms_px", cell.inlier_rms_px},
          {"bound_theta_deg", cell.bound_theta_deg},
          {"bound_t_percent", cell.bound_t_percent},
          {"bound_geodesic_deg", cell.bound_geodesic_deg}};
}

Json feature_json(const Study& study, const FeatureSummary& feature) {
  return {{"condition", condition_json(study, feature.condition)},
          {"feature", feature.feature},
          {"trials_visible", feature.visible},
          {"trials_found", feature.found},
          {"trials_outlier", feature.outliers},
          {"inlier_rms_px", feature.inlier_rms_px},
          {"median_error_px", feature.median_px}};
}

}  // namespace

Summary summarise(const Study& study, std::span<const TrialRecord> trials) {
  if (study.kind == StudyKind::kOrientation) return summarise_orientations(study, trials);
  Summary summary;
  const Positions positions = positions_of(study);
  for (int condition = 0; condition < static_cast<int>(study.conditions.size()); ++condition) {
    const Trials of_cell = trials_of(trials, condition);
    std::vector<FeatureSummary> features;
    for (const std::string& feature : features_in(of_cell)) {
      features.push_back(summarise_feature(of_cell, condition, feature));
    }
    const auto bounds = bounds_of(study, positions, of_cell, condition, features);
    CellObservations observations = summarise_observations(of_cell, condition);
    set_bounds(bounds, observations);
    for (const PoseSolver* solver : study.solvers) {
      summary.cells.push_back(summarise_cell(study, of_cell, condition, solver->name));
      set_ratios(study, of_cell, bounds, observations, summary.cells.back());
    }
    summary.observations.push_back(observations);
    summary.features.insert(summary.features.end(), features.begin(), features.end());
  }
  return summary;
}

std::string to_json(const Study& study, const Summary& summary) {
  Json json = {{"study", study.name}, {"seed", study.seed}};
  json["cells"] = Json::array();
  for (const CellSummary& cell : summary.cells) json["cells"].push_back(cell_json(study, cell));
  if (study.kind == StudyKind::kOrientation) return json.dump(2) + "\n";
  json["observations"] = Json::array();
  for (const CellObservations& cell : summary.observations) {
    json["observations"].push_back(observations_json(study, cell));
  }
  json["features"] = Json::array();
  for (const FeatureSummary& feature : summary.features) {
    json["features"].push_back(feature_json(study, feature));
  }
  return json.dump(2) + "\n";
}

}  // namespace sightline
