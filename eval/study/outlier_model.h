// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "eval/records/records.h"

namespace sightline {

/// The failures of feature extraction as an image study measured them: what went wrong together in
/// each of its trials. A numeric study replays them, trial by trial, so that failures keep their
/// company (a background that spoils one corner spoils its neighbours).
struct OutlierModel {
  /// A feature that was seen, but found elsewhere or not at all.
  struct Failure {
    std::string feature;
    bool is_missing = false;
    Eigen::Vector2d displacement_px = Eigen::Vector2d::Zero();  ///< from the truth; if found
  };
  std::vector<std::vector<Failure>> trials;  ///< empty where nothing failed
};

/// What the trials' labels say: outliers with their displacements, and features missing though
/// they are to be seen. Takes the first `kMostModelTrials` trials that have observations.
OutlierModel outlier_model_of(std::span<const TrialRecord> trials);

constexpr size_t kMostModelTrials = 20'000;

/// outliers.json: {"features": [...], "trials": [[[feature, du, dv], [feature], ...], ...]} with
/// features by their index, and no displacement of one that is missing. `study` is noted in it.
std::string to_json(const OutlierModel& model, const std::string& study);

/// Throws InputError for a file that is no such model.
OutlierModel read_outlier_model(const std::filesystem::path& file);

}  // namespace sightline
