// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The keys of a numeric study. The values of [sweep] make the cells; what is not swept has its
// value elsewhere in the file.
#include <array>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "eval/study/key_tables.h"
#include "eval/study/study_keys.h"
#include "eval/study/sweep_keys.h"

namespace sightline {
namespace {

// Tables whose keys can be swept.
const std::vector<std::string> kSweptOfNumeric = {"camera", "edges", "noise", "outliers",
                                                  "poses",  "prior", "solver"};

// A model replaces the law: features fail as they did in one of its trials.
void read_model(const TomlTable& table, const NumericStudy& study, PlantedOutliers& planted) {
  planted.law = OutlierLaw::kModel;
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
  if (planted.rate > 0) table.fail("rate", "cannot stand beside outliers.model");
  planted.model = std::move(model);
}

// How many outliers a trial has: swept or given, and none beside a model, which says it itself. A
// rate can stand alone.
Axis read_outlier_counts(const TomlTable& sweep, const TomlTable& outliers,
                         const NumericStudy& study) {
  if (!outliers.has("model")) {
    const std::optional<double> if_absent =
        outliers.has("rate") ? std::optional<double>(0) : std::nullopt;
    return read_count_axis(sweep, "outliers", {outliers, "outliers", "count"},
                           {0, static_cast<double>(study.features.size())}, if_absent);
  }
  if (sweep.has("outliers")) sweep.fail("outliers", "cannot stand beside outliers.model");
  outliers.has("count");
  return {{0}, false};
}

NumericSetup read_numeric_setup(const TomlTable& table, const NumericStudy& study) {
  NumericSetup setup;
  setup.camera = read_camera(table.table("camera"));
  const TomlTable poses = table.table("poses");
  setup.poses.is_attitude_uniform = !poses.has("angle_deg");
  if (poses.has("angle_deg")) {
    setup.poses.drawn_angle_deg = read_range(poses, "angle_deg", {-180, 180});
  }
  read_position_ranges(poses, setup.poses);
  setup.prior = read_prior(table.table("prior"));
  read_keys(table, solver_keys(setup.start, setup.options));
  read_keys(table, sigma_keys(setup.is_sigma_known));
  table.table("solver").has("inputs");  // which is read for all set-ups
  read_keys(table, noise_keys(setup.noise));
  read_keys(table, keys_of(setup.planted));
  read_keys(table, keys_of(setup.edges));
  const TomlTable outliers = table.table("outliers");
  if (outliers.has("model")) read_model(outliers, study, setup.planted);
  return setup;
}

// What has no meaning beside edges is refused.
void require_edges_alone(const TomlTable& table, const NumericSetup& setup) {
  if (setup.edges.observed == SeenEdges::Observed::kNothing) return;
  const TomlTable edges = table.table("edges");
  if (!is_straight(setup.camera)) edges.fail("observed", "needs a camera without lens and skew");
  if (setup.noise.tails != NoiseLaw::Tails::kNormal) {
    edges.fail("observed", "needs noise.law = \"normal\"");
  }
}

// Wrong lines need lines, and edges enough that each is one.
void require_edges_for_wrong_lines(const TomlTable& outliers, const NumericStudy& study) {
  const NumericSetup& setup = study.setups.back();
  if (setup.planted.lines == 0) return;
  if (!setup.edges.has_lines()) {
    outliers.fail("lines", "must be 0 where edges.observed is neither \"lines\" nor \"both\"");
  }
  const size_t edges = different_edges(*study.target, study.features).size();
  if (static_cast<size_t>(setup.planted.lines) <= edges) return;
  outliers.fail("lines", fmt::format("is {}, but the features have only {} edges",
                                     setup.planted.lines, edges));
}

// The cells of one set-up: its noise and outliers, where these are swept by themselves.
void add_numeric_cells(const TomlTable& table, const Condition& swept, NumericStudy& study,
                       std::vector<Condition>& conditions) {
  const TomlTable sweep = table.table("sweep");
  const TomlTable noise = table.table("noise");
  const TomlTable outliers = table.table("outliers");
  const double scale = read_noise_scale(table);
  const Axis noises = read_axis(sweep, "noise_px", {noise, "noise", "pixel_px"},
                                find_key(axis_keys(), "noise.pixel_px").allowed);
  const Axis counts = read_outlier_counts(sweep, outliers, study);
  const int setup = static_cast<int>(study.setups.size()) - 1;
  require_edges_alone(table, study.setups.back());
  require_edges_for_wrong_lines(outliers, study);
  for (const double count : counts.values) {
    const std::string reason = why_not_plantable(
        study.setups.back().planted, static_cast<int>(count), *study.target, study.features);
    if (!reason.empty()) outliers.fail("law", reason);
    if (count > 0 && !study.setups.back().edges.has_points()) {
      outliers.fail("count", "must be 0 where edges are lines alone: outliers are points");
    }
    for (const double noise_px : noises.values) {
      if (noise_px * scale == 0 &&
          study.setups.back().edges.observed != SeenEdges::Observed::kNothing) {
        table.table("edges").fail("observed", "needs edge pixels with noise: noise.pixel_px is 0");
      }
      const std::array coordinates = {
          Coordinate{noises, "noise_px", fmt::format("{} px", noise_px), noise_px},
          Coordinate{counts, "outliers", fmt::format("{} outlier{}", count, count == 1 ? "" : "s"),
                     count}};
      conditions.push_back(joined(swept, condition_at(coordinates)));
      study.cells.push_back(
          {.noise_px = scale * noise_px, .outliers = static_cast<int>(count), .setup = setup});
      require_few_cells(table, study.cells.size());
    }
  }
}

// A set-up for every cell of the sweep's quoted keys; in each of them the noise and the outliers.
void read_numeric_sweep(const TomlTable& table, NumericStudy& study,
                        std::vector<Condition>& conditions) {
  const std::vector<SweptCell> cells =
      read_sweeps(table, kSweptOfNumeric, {"noise_px", "outliers"});
  const std::vector<Condition> swept = conditions_of(cells);
  for (const SweptValue& value : cells.front()) {
    if (value.key != "solver.inputs") continue;
    table.table("sweep").fail(value.key, "cannot be swept: every cell has the same inputs");
  }
  study.setups.clear();
  for (size_t i = 0; i < cells.size(); ++i) {
    with_swept_values(table, cells[i], [&](const TomlTable& set) {
      study.setups.push_back(read_numeric_setup(set, study));
      add_numeric_cells(set, swept[i], study, conditions);
      for (const std::string& name : kSweptOfNumeric) set.table(name).reject_unknown_keys();
    });
  }
  if (cells.front().empty()) return;
  read_numeric_setup(table, study);  // the keys as they stand are checked, though all be swept
  read_noise_scale(table);
  for (const auto& [name, key] : {std::pair{"noise", "pixel_px"}, {"outliers", "count"}}) {
    table.table(name).has(key);  // which counts as known
  }
}

void read_limits(const TomlTable& table, NumericStudy& study) {
  if (!table.has("limits")) return;
  read_keys(table, limit_keys(study.limits.emplace()));
}

}  // namespace

NumericStudy read_numeric_study(const TomlTable& table, Study& common, const Guests& guests) {
  NumericStudy study;
  study.solving = read_solving(table, "free", read_guest_solvers(table, nullptr, guests.solvers));
  study.target = read_target(table);
  study.features = read_features(table, Use::kTrials, *study.target);
  read_numeric_sweep(table, study, common.conditions);
  read_limits(table, study);
  return study;
}

}  // namespace sightline
