// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is measured of estimates, one row a measure: score_bop computes from these tables, and the
// files, the terminal and the page tell from them.
#pragma once

#include <span>
#include <string_view>
#include <variant>

#include <Eigen/Core>

#include "eval/score/score.h"
#include "pose/pose.h"

namespace sightline {

/// An estimate, the true pose that it is held against, and what they are of; millimetres.
struct PairPoses {
  const Eigen::Matrix3Xd& points_mm;
  const Eigen::Matrix3d& k;
  std::span<const Pose> symmetries;
  const Pose& estimated;
  const Pose& truth;
  const Pose& alike;  ///< the true pose at the symmetry that is nearest to the estimate
};

/// A number of every pair, which errors.csv has.
struct PairMeasure {
  std::string_view column;
  double BopPair::*number;
  double (*of)(const PairPoses& poses);
  bool needs_model = true;  ///< without the object's vertices it is NaN
};

/// The share of targets that an estimate is good for.
struct RecallMeasure {
  std::string_view key;         ///< in scores.json
  std::string_view text_label;  ///< in the terminal's table
  std::string_view page_label;
  BopRate BopSummary::*summary;
  bool (*is_good)(const BopTarget& target);
  bool needs_model = true;
};

enum class Told { kMedian, kMean };

/// The error of the targets' chosen estimates; one without has failed, and counts as `cap` in
/// means.
struct ErrorMeasure {
  std::string_view key;
  std::string_view text_label;
  std::string_view page_label;
  ErrorSummary BopSummary::*summary;
  double BopPair::*error;
  double cap;
  std::string_view stream;  ///< of random numbers, for its intervals
  Told told;                ///< by the terminal and the page
};

using SummaryMeasure = std::variant<RecallMeasure, ErrorMeasure>;

/// All, in the order in which files have them.
std::span<const PairMeasure> pair_measures();
std::span<const SummaryMeasure> summary_measures();

}  // namespace sightline
