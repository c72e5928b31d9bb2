// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The keys of a study of the absolute orientation.
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "eval/study/key_tables.h"
#include "eval/study/study_keys.h"
#include "eval/study/sweep_keys.h"

namespace sightline {
namespace {

std::vector<StudyMethod> known_methods() {
  std::vector<StudyMethod> known;
  for (const OrientationMethod& method : orientation_methods()) known.emplace_back(&method);
  for (const RobustAlignmentMethod& method : robust_alignment_methods()) {
    known.emplace_back(&method);
  }
  return known;
}

void read_methods(const TomlTable& table, OrientationStudy& study) {
  const std::vector<StudyMethod> known = known_methods();
  std::vector<std::string> names;
  for (const StudyMethod& method : known) names.emplace_back(name_of(method));
  std::set<std::string> seen;
  for (const std::string& name : table.texts("methods", names_of(orientation_methods()))) {
    study.methods.push_back(known[index_of(name, names, table, "methods")]);
    if (!seen.insert(name).second) {
      table.fail("methods", fmt::format("holds \"{}\" twice", name));
    }
  }
  if (study.methods.empty()) table.fail("methods", "is empty, must name at least one method");
}

/// One value of each axis.
struct OrientationCondition {
  double count;
  double sigma;
  double share;
  double scale;
};

/// All combinations; the last axis runs fastest.
std::vector<OrientationCondition> combined(const Axis& counts, const Axis& sigmas,
                                           const Axis& shares, const Axis& scales) {
  std::vector<OrientationCondition> all;
  for (const double count : counts.values) {
    for (const double sigma : sigmas.values) {
      for (const double share : shares.values) {
        for (const double scale : scales.values) all.push_back({count, sigma, share, scale});
      }
    }
  }
  return all;
}

/// How many of so many pairs are wrong.
int outliers_of(double share, int points, const Axis& shares, const TomlTable& sweep,
                const TomlTable& outliers) {
  const int count = static_cast<int>(std::lround(share * points));
  if (points - count < 3) {
    (shares.is_swept ? sweep : outliers)
        .fail("share", fmt::format("is {} of {} points, must leave at least three", share, points));
  }
  return count;
}

}  // namespace

OrientationStudy read_orientation_study(const TomlTable& table, Study& common) {
  OrientationStudy study;
  read_methods(table, study);
  read_keys(table, point_keys(study.pairs));
  read_keys(table, sigma_keys(study.pairs.is_sigma_known));
  read_keys(table, scale_keys(study.pairs.estimates_scale));
  const TomlTable points = table.table("points");
  const TomlTable sweep = table.table("sweep");
  const TomlTable noise = table.table("noise");
  const TomlTable outliers = table.table("outliers");
  const double scale = read_noise_scale(table);
  const Axis sigmas = read_axis(sweep, "sigma", {noise, "noise", "sigma_m"},
                                find_key(axis_keys(), "noise.sigma_m").allowed);
  const Axis counts = read_count_axis(sweep, "points", {points, "points", "count"},
                                      find_key(axis_keys(), "points.count").allowed);
  const Axis shares = read_axis(sweep, "share", {outliers, "outliers", "share"},
                                find_key(axis_keys(), "outliers.share").allowed, 0);
  const Axis scales = read_axis(sweep, "scale", {points, "points", "scale"},
                                find_key(axis_keys(), "points.scale").allowed, 1);
  for (const OrientationCondition& one : combined(counts, sigmas, shares, scales)) {
    const std::array coordinates = {
        Coordinate{counts, "points", fmt::format("{} points", one.count), one.count},
        Coordinate{sigmas, "sigma", fmt::format("sigma {}", one.sigma), one.sigma},
        Coordinate{shares, "share", fmt::format("{} % wrong", 100 * one.share), one.share},
        Coordinate{scales, "scale", fmt::format("scale {}", one.scale), one.scale}};
    common.conditions.push_back(condition_at(coordinates));
    const int count = static_cast<int>(one.count);
    study.cells.push_back({.noise_m = scale * one.sigma,
                           .points = count,
                           .outliers = outliers_of(one.share, count, shares, sweep, outliers),
                           .scale = one.scale});
    require_few_cells(table, study.cells.size());
  }
  return study;
}

}  // namespace sightline
