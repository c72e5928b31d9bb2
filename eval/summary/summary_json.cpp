// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/summary_json.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <nlohmann/json.hpp>

#include "eval/output/json.h"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json measured_json(const Measured& measured) {
  return {{"value", number(measured.value)},
          {"ci95", {number(measured.ci95[0]), number(measured.ci95[1])}}};
}

Json localisation_json(const Localisation& l) {
  std::map<std::string, int64_t> labels;
  for (const auto& [label, count] : l.labels) labels[std::string(to_string(label))] = count;
  return {
      {"visible", l.visible},
      {"found", l.found},
      {"found_rate", measured_json(l.found_rate)},
      {"outlier_rate", measured_json(l.outlier_rate)},
      {"near_rate", measured_json(l.near_rate)},
      {"seen_outlier_rate", measured_json(l.seen_outlier_rate)},
      {"near_median_px", number(l.near_median_px)},
      {"near_rms_px", number(l.near_rms_px)},
      {"rms_px", measured_json(l.rms_px)},
      {"bias_u_px", measured_json(l.bias_u_px)},
      {"bias_v_px", measured_json(l.bias_v_px)},
      {"rms_sigmas", measured_json(l.rms_sigmas)},
      {"outlier_px", {number(l.outlier_px[0]), number(l.outlier_px[1]), number(l.outlier_px[2])}},
      {"outlier_side", {number(l.outlier_side[0]), number(l.outlier_side[1])}},
      {"labels", labels}};
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
  return {{"mean", error.mean},     {"mean_ci95", error.mean_ci95},
          {"median", error.median}, {"median_ci95", error.median_ci95},
          {"rms", error.rms},       {"rms_ci95", error.rms_ci95},
          {"p90", error.p90},       {"p90_ci95", error.p90_ci95}};
}

Json nees_json(const NeesSummary& nees) {
  if (nees.trials == 0) return nullptr;
  return {{"trials", nees.trials},
          {"mean", nees.mean},
          {"mean_ci95", kNoInterval},
          {"coverage95", nees.coverage95},
          {"coverage95_ci95", nees.coverage95_ci95},
          {"median", nees.median.value},
          {"median_ci95", nees.median.ci95}};
}

// Those of poses first; what orientations alone have stands at the end of a cell.
void add_errors(Json& json, const CellSummary& cell, bool is_orientation, bool are_of_poses) {
  for (const Quantity& quantity : quantities()) {
    const bool is_of_kind = is_orientation ? quantity.of_orientation != nullptr : are_of_poses;
    const bool is_of_poses = quantity.of_estimate != nullptr;
    if (!is_of_kind || is_of_poses != are_of_poses || quantity.is_time) continue;
    json[quantity.name] = error_json(cell.*quantity.summary);
  }
}

Json cell_json(const Study& study, const CellSummary& cell) {
  const bool is_orientation = study.orientation() != nullptr;
  Json json = {{"condition", condition_json(study, cell.condition)},
               {"solver", cell.solver},
               {"trials", cell.trials},
               {"failures", cell.failures}};
  add_errors(json, cell, is_orientation, /*are_of_poses=*/true);
  json["ratio_to_oracle"] = cell.ratio_to_oracle;
  json["ratio_to_bound"] = cell.ratio_to_bound;
  json["false_removals"] = cell.false_removals;
  json["missed_outliers"] = cell.missed_outliers;
  json["exact_set_rate"] = cell.exact_set_rate;
  json["capped"] = cell.geodesic_deg.capped;
  json["failure_rate_ci95"] = cell.failure_rate_ci95;
  json["exact_set_rate_ci95"] = cell.exact_set_rate_ci95;
  // No interval of these two holds (RmsRatio); those of their medians do.
  json["ratio_to_oracle_ci95"] = kNoInterval;
  json["ratio_to_bound_ci95"] = kNoInterval;
  json["nees"] = nees_json(cell.nees);
  json["ratio_to_oracle_median"] = cell.ratio_to_oracle_median.value;
  json["ratio_to_oracle_median_ci95"] = cell.ratio_to_oracle_median.ci95;
  json["ratio_to_bound_median"] = cell.ratio_to_bound_median.value;
  json["ratio_to_bound_median_ci95"] = cell.ratio_to_bound_median.ci95;
  if (is_orientation) {
    json["copies"] = study.orientation()->pairs.copies;
    json["failed_copies"] = cell.failed_copies;
    add_errors(json, cell, is_orientation, /*are_of_poses=*/false);
  }
  return json;
}

Json observations_json(const Study& study, const CellObservations& cell) {
  return {{"condition", condition_json(study, cell.condition)},
          {"trials", cell.trials},
          {"trials_repeated", cell.repeated},
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

std::string to_json(const Study& study, const FeatureStatistics& statistics) {
  Json cells = Json::array();
  for (size_t c = 0; c < study.conditions.size(); ++c) {
    const int condition = static_cast<int>(c);
    Json features = Json::array();
    for (const std::string& feature : statistics.features()) {
      Json of_feature = {{"feature", feature}};
      of_feature.update(localisation_json(statistics.of(condition, feature)));
      features.push_back(std::move(of_feature));
    }
    Json cell = {{"condition", study.conditions[c].label}};
    cell.update(localisation_json(statistics.of_cell(condition)));
    cell["features"] = std::move(features);
    cells.push_back(std::move(cell));
  }
  return cells.dump(1);
}

std::string to_json(const Study& study, const Summary& summary) {
  Json json = {{"study", study.name}, {"seed", study.seed}};
  json["cells"] = Json::array();
  for (const CellSummary& cell : summary.cells) json["cells"].push_back(cell_json(study, cell));
  if (study.orientation() != nullptr) return json_text(json);
  json["observations"] = Json::array();
  for (const CellObservations& cell : summary.observations) {
    json["observations"].push_back(observations_json(study, cell));
  }
  json["features"] = Json::array();
  for (const FeatureSummary& feature : summary.features) {
    json["features"].push_back(feature_json(study, feature));
  }
  if (summary.extraction) json["extraction"] = Json::parse(to_json(study, *summary.extraction));
  return json_text(json);
}

}  // namespace sightline
