// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The keys of a study of the absolute orientation.
#include <array>
#include <set>

#include <fmt/format.h>

#include "eval/study/key_tables.h"
#include "eval/study/study_keys.h"
#include "eval/study/sweep_keys.h"

namespace sightline {
namespace {

void read_methods(const TomlTable& table, OrientationStudy& study) {
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

OrientationStudy read_orientation_study(const TomlTable& table, Study& common) {
  OrientationStudy study;
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
      common.conditions.push_back(condition_at(coordinates));
      study.cells.push_back({.noise_m = scale * sigma, .points = static_cast<int>(count)});
    }
  }
  return study;
}

}  // namespace sightline
