// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "eval/records/caps.h"
#include "eval/records/records.h"
#include "eval/study/study.h"
#include "eval/summary/cells.h"
#include "eval/summary/feature_statistics.h"
#include "eval/summary/ladder.h"

namespace sightline {

struct Summary {
  std::vector<CellSummary> cells;  ///< by condition, then in the study's order of solvers
  std::vector<CellObservations> observations;   ///< by condition
  std::vector<FeatureSummary> features;         ///< by condition, then in the study's order
  std::optional<FeatureStatistics> extraction;  ///< of a study with images
  std::vector<LadderStep> ladder;               ///< of one with the image's bound
};

/// Trials that are all in memory, in any order, as a source; they must outlive it.
TrialSource in_order(std::span<const TrialRecord> trials);

/// Goes through the trials once, or where there are images twice, in memory that does not grow with
/// their number once each cell has ErrorStatistics::kMostValuesKept. Of an orientation study there
/// are cells, and observations that hold nothing but the number of trials.
Summary summarise(const Study& study, const TrialSource& trials);

/// The same of trials in memory, whose order does not matter.
Summary summarise(const Study& study, std::span<const TrialRecord> trials);

/// How many trials a relative half-width of `target` of the 95 % intervals of a cell's mean
/// theta_error (near gimbal lock the geodesic angle) and T_error needs (trials_for); none of a cell
/// whose trials say nothing, or err by rounding alone.
std::optional<int64_t> trials_needed(const CellSummary& cell, double target);

}  // namespace sightline
