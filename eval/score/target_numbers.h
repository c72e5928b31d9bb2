// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What `score` knows of each target by itself: the columns of targets.csv, by which `compare` pairs
// two scores of a data set.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "eval/score/score.h"

namespace sightline {

enum class TargetNumberKind {
  kFlag,   ///< 1 where the target is found well enough, else 0
  kShare,  ///< of the thresholds that it passes
  kError,  ///< of its estimate
};

struct TargetNumber {
  std::string name;  ///< as in scores.json, or of errors that it has not as in errors.csv
  std::string meaning;
  TargetNumberKind kind = TargetNumberKind::kError;
  double cap = std::numeric_limits<double>::infinity();  ///< that a missed target's error counts as
  /// NaN where the data set does not let it be known, infinite of the error of a missed target.
  std::function<double(const BopScores& scores, const BopTarget& target)> of;
};

/// Whether somebody means the figure of this name: "AR" is "ar", "ADD" is "add_recall",
/// "ADD(-S)" is "add_s_recall" and "ADD-S" is "adi_recall".
bool is_called(std::string_view given, std::string_view name);

/// All: average recalls, recalls, errors; the last two by the tables of measures.h.
const std::vector<TargetNumber>& target_numbers();

}  // namespace sightline
