// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The keys of studies that draw no images: numeric ones and those of the absolute orientation. The
// values of [sweep] make the cells; what is not swept has its value elsewhere in the file.
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "eval/study/key_tables.h"
#include "eval/study/study_keys.h"

namespace sightline {
namespace {

// A quantity that is swept, or has one value.
struct Axis {
  std::vector<double> values;
  bool is_swept = false;
};

// Where the value of a quantity stands that is not swept.
struct Place {
  const TomlTable& table;
  const char* name;  // of the table
  const char* key;
};

Axis read_axis(const TomlTable& sweep, const char* key, const Place& fixed, Interval allowed) {
  if (!sweep.has(key)) return {{fixed.table.number(fixed.key, allowed)}, false};
  if (fixed.table.has(fixed.key)) {
    sweep.fail(key, fmt::format("cannot stand beside {}.{}: give one or the other", fixed.name,
                                fixed.key));
  }
  return {sweep.number_list(key, allowed), true};
}

// An axis of counts.
Axis read_count_axis(const TomlTable& sweep, const char* key, const Place& fixed,
                     Interval allowed) {
  const Axis axis = read_axis(sweep, key, fixed, allowed);
  for (const double value : axis.values) {
    if (value == std::floor(value)) continue;
    const std::string message = fmt::format("holds {}, must hold whole numbers", value);
    if (axis.is_swept) sweep.fail(key, message);
    fixed.table.fail(fixed.key, message);
  }
  return axis;
}

// The cell of one value an axis: what is swept is its condition.
struct Coordinate {
  const Axis& axis;
  std::string key;    // in summary.json
  std::string label;  // for readers
  double value = 0;
};

Condition condition_at(std::span<const Coordinate> coordinates) {
  Condition condition;
  for (const Coordinate& c : coordinates) {
    if (!c.axis.is_swept) continue;
    condition.values[c.key] = c.value;
    condition.label += (condition.label.empty() ? "" : ", ") + c.label;
  }
  if (condition.label.empty()) condition.label = "all";
  return condition;
}

// A model replaces the law: features fail as they did in one of its trials.
void read_model(const TomlTable& table, Study& study) {
  study.planted.law = OutlierLaw::kModel;
  auto model = std::make_shared<OutlierModel>(read_outlier_model(table.text("model")));
  std::set<std::string> known;
  for (const int feature : study.features) known.insert(study.target->features[feature].name);
  for (const auto& failures : model->trials) {
    for (const OutlierModel::Failure& failure : failures) {
      if (known.contains(failure.feature)) continue;
      table.fail("model",
                 fmt::format("is of other features: the study has no \"{}\"", failure.feature));
    }
  }
  study.planted.model = std::move(model);
}

// How many outliers a trial has: swept or given, and none beside a model, which says it itself.
Axis read_outlier_counts(const TomlTable& sweep, const TomlTable& outliers, const Study& study) {
  if (!outliers.has("model")) {
    return read_count_axis(sweep, "outliers", {outliers, "outliers", "count"},
                           {0, static_cast<double>(study.features.size())});
  }
  if (sweep.has("outliers")) sweep.fail("outliers", "cannot stand beside outliers.model");
  outliers.has("count");
  return {{0}, false};
}

void read_planted(const TomlTable& file, Study& study) {
  read_keys(file, keys_of(study.planted));
  const TomlTable table = file.table("outliers");
  if (table.has("model")) read_model(table, study);
}

void read_numeric_sweep(const TomlTable& table, Study& study) {
  const TomlTable sweep = table.table("sweep");
  const TomlTable noise = table.table("noise");
  const TomlTable outliers = table.table("outliers");
  const double scale = read_noise_scale(table);
  const Axis noises = read_axis(sweep, "noise_px", {noise, "noise", "pixel_px"},
                                find_key(axis_keys(), "noise.pixel_px").allowed);
  const Axis counts = read_outlier_counts(sweep, outliers, study);
  read_planted(table, study);
  for (const double count : counts.values) {
    const std::string reason =
        why_not_plantable(study.planted, static_cast<int>(count), *study.target, study.features);
    if (!reason.empty()) outliers.fail("law", reason);
    for (const double noise_px : noises.values) {
      const std::array coordinates = {
          Coordinate{noises, "noise_px", fmt::format("{} px", noise_px), noise_px},
          Coordinate{counts, "outliers", fmt::format("{} outlier{}", count, count == 1 ? "" : "s"),
                     count}};
      Condition& cell = study.conditions.emplace_back(condition_at(coordinates));
      cell.noise_sd = scale * noise_px;
      cell.outliers = static_cast<int>(count);
    }
  }
}

void read_limits(const TomlTable& table, Study& study) {
  if (!table.has("limits")) return;
  read_keys(table, limit_keys(study.limits.emplace()));
}

void read_methods(const TomlTable& table, Study& study) {
  const std::vector<std::string> known = names_of(orientation_methods());
  std::set<std::string> seen;
  for (const std::string& name : table.texts("methods", known)) {
    study.methods.push_back(&orientation_methods()[index_of(name, known, table, "methods")]);
    if (!seen.insert(name).second) {
      table.fail("methods", fmt::format("holds \"{}\" twice", name));
    }
  }
  if (study.methods.empty()) table.fail("methods", "is empty, must name at least one method");
}

}  // namespace

void read_numeric_study(const TomlTable& table, Study& study) {
  study.camera = read_camera(table.table("camera"));
  const TomlTable poses = table.table("poses");
  study.poses.is_attitude_uniform = !poses.has("angle_deg");
  if (poses.has("angle_deg")) {
    study.poses.drawn_angle_deg = read_range(poses, "angle_deg", {-180, 180});
  }
  read_position_ranges(poses, study.poses);
  study.prior = read_prior(table.table("prior"));
  read_solvers(table, "free", study);
  read_keys(table, sigma_keys(study.is_sigma_known));
  read_target_and_features(table, study);
  read_numeric_sweep(table, study);
  read_limits(table, study);
}

void read_orientation_study(const TomlTable& table, Study& study) {
  read_methods(table, study);
  read_keys(table, point_keys(study.pairs));
  const TomlTable points = table.table("points");
  const TomlTable sweep = table.table("sweep");
  const TomlTable noise = table.table("noise");
  const double scale = read_noise_scale(table);
  const Axis sigmas = read_axis(sweep, "sigma", {noise, "noise", "sigma_m"},
                                find_key(axis_keys(), "noise.sigma_m").allowed);
  const Axis counts = read_count_axis(sweep, "points", {points, "points", "count"},
                                      find_key(axis_keys(), "points.count").allowed);
  for (const double count : counts.values) {
    for (const double sigma : sigmas.values) {
      const std::array coordinates = {
          Coordinate{counts, "points", fmt::format("{} points", count), count},
          Coordinate{sigmas, "sigma", fmt::format("sigma {}", sigma), sigma}};
      Condition& cell = study.conditions.emplace_back(condition_at(coordinates));
      cell.noise_sd = scale * sigma;
      cell.points = static_cast<int>(count);
    }
  }
}

}  // namespace sightline
