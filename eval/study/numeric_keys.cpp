// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The keys of a numeric study. The values of [sweep] make the cells; what is not swept has its
// value elsewhere in the file.
#include <array>
#include <set>

#include <fmt/format.h>

#include "eval/study/key_tables.h"
#include "eval/study/study_keys.h"
#include "eval/study/sweep_keys.h"

namespace sightline {
namespace {

// A model replaces the law: features fail as they did in one of its trials.
void read_model(const TomlTable& table, NumericStudy& study) {
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
Axis read_outlier_counts(const TomlTable& sweep, const TomlTable& outliers,
                         const NumericStudy& study) {
  if (!outliers.has("model")) {
    return read_count_axis(sweep, "outliers", {outliers, "outliers", "count"},
                           {0, static_cast<double>(study.features.size())});
  }
  if (sweep.has("outliers")) sweep.fail("outliers", "cannot stand beside outliers.model");
  outliers.has("count");
  return {{0}, false};
}

void read_planted(const TomlTable& file, NumericStudy& study) {
  read_keys(file, keys_of(study.planted));
  const TomlTable table = file.table("outliers");
  if (table.has("model")) read_model(table, study);
}

void read_numeric_sweep(const TomlTable& table, NumericStudy& study,
                        std::vector<Condition>& conditions) {
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
      conditions.push_back(condition_at(coordinates));
      study.cells.push_back({.noise_px = scale * noise_px, .outliers = static_cast<int>(count)});
    }
  }
}

void read_limits(const TomlTable& table, NumericStudy& study) {
  if (!table.has("limits")) return;
  read_keys(table, limit_keys(study.limits.emplace()));
}

}  // namespace

NumericStudy read_numeric_study(const TomlTable& table, Study& common, const Guests& guests) {
  NumericStudy study;
  study.camera = read_camera(table.table("camera"));
  const TomlTable poses = table.table("poses");
  study.poses.is_attitude_uniform = !poses.has("angle_deg");
  if (poses.has("angle_deg")) {
    study.poses.drawn_angle_deg = read_range(poses, "angle_deg", {-180, 180});
  }
  read_position_ranges(poses, study.poses);
  study.prior = read_prior(table.table("prior"));
  study.solving = read_solving(table, "free", read_guest_solvers(table, nullptr, guests.solvers));
  read_keys(table, sigma_keys(study.is_sigma_known));
  study.target = read_target(table);
  study.features = read_features(table, Use::kTrials, *study.target);
  read_numeric_sweep(table, study, common.conditions);
  read_limits(table, study);
  return study;
}

}  // namespace sightline
