// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <optional>
#include <string>

#include "eval/records/caps.h"
#include "eval/records/records.h"
#include "eval/statistics/error_statistics.h"
#include "eval/statistics/rms_ratio.h"
#include "eval/study/study.h"
#include "eval/summary/cells.h"
#include "eval/summary/quantities.h"
#include "eval/summary/trial_bounds.h"

namespace sightline {

/// What the estimates of one trial are held against.
struct TrialReference {
  int outliers = 0;                        ///< that the trial's observations have
  const EstimateRecord* oracle = nullptr;  ///< null: it has no pose, or ratios say nothing
  std::optional<TrialBound> bound;
};

/// The pose that a solver has of a trial; null when it failed or is not there.
const EstimateRecord* pose_of(const TrialRecord& trial, std::string_view solver);

/// One solver in one condition of a study that estimates poses, trial by trial.
class PoseCell {
 public:
  PoseCell(int condition, std::string solver) : condition_(condition), solver_(solver) {}

  void add(const TrialRecord& trial, const TrialReference& reference);
  /// `trials` is how many the condition has.
  CellSummary summary(const Study& study, int trials) const;

 private:
  void add_pose(const EstimateRecord& estimate);
  NeesSummary nees_summary() const;

  int condition_;
  std::string solver_;
  int failures_ = 0;
  CellErrorStatistics errors_;
  int64_t false_removals_ = 0;
  int64_t missed_outliers_ = 0;
  int64_t exact_ = 0;  // trials in which exactly the outliers were removed
  bool is_near_lock_ = false;
  RmsRatio to_oracle_;
  RmsRatio to_bound_;
  // Capped, of the trials in which the oracle has a pose.
  ErrorStatistics theta_beside_oracle_{kAngleCapDeg};
  ErrorStatistics t_beside_oracle_{kTranslationCapPercent};
  // The same of each trial, a failure's being infinite.
  ErrorStatistics oracle_ratios_{std::numeric_limits<double>::infinity()};
  ErrorStatistics bound_ratios_{std::numeric_limits<double>::infinity()};
  ErrorStatistics nees_{std::numeric_limits<double>::infinity()};
  int64_t nees_covered_ = 0;
};

}  // namespace sightline
