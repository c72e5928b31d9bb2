// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "eval/statistics/statistics.h"

namespace sightline {

/// A change counts where its p-value, adjusted over all numbers that are compared, is below this.
inline constexpr double kVerdictLevel = 0.05;

enum class Verdict { kUnchanged, kBetter, kWorse, kMissing };

/// "unchanged", "better", "worse", "missing".
std::string_view to_string(Verdict verdict);

/// One measure of a cell in two runs.
struct Difference {
  std::string quantity;  ///< the measure's name: "geodesic_deg.mean", "failure_rate"
  int64_t trials = 0;    ///< pairs, or where there are none the new run's trials
  double base = kNoNumber;
  double now = kNoNumber;
  Interval95 ci95 = kNoInterval;  ///< of now - base
  double p = 1;  ///< of no change beyond the tolerance; Holm-adjusted over the whole comparison
  Verdict verdict = Verdict::kUnchanged;
  // Of a middle: in how many trials the new run's number is greater, and less.
  int64_t greater = 0;
  int64_t less = 0;
};

/// One solver in one condition.
struct CellDifference {
  std::string condition;  ///< "noise_px 0.5", or "all" where a study has one
  std::string solver;     ///< or "features": what the images gave, whatever the solver
  std::vector<Difference> differences;
  /// Worse where any of its numbers is, else better where any is; missing where the new run lacks
  /// the cell.
  Verdict verdict = Verdict::kUnchanged;
};

struct Comparison {
  std::string study;
  std::string how;       ///< a sentence: paired on which trials or, if not, why
  std::string settings;  ///< a sentence: which settings differ, as their studies were run
  double tolerance = 0;
  std::vector<CellDifference> cells;  ///< in the order of the base
  int64_t count(Verdict verdict) const;
  /// A cell is worse or missing.
  bool has_regression() const { return count(Verdict::kWorse) + count(Verdict::kMissing) > 0; }
};

/// Compares two runs of one study, each a run's folder or a summary.json alone, by the measures of
/// these names (find_measures) or the default ones.
///
/// Where both have their trials and these are the same draws (same number, condition and true
/// pose), they are compared trial by trial (paired_difference). Otherwise they are compared by what
/// their summaries store (stored_difference). That is sound for any two runs, and of runs of the
/// same draws only less sensitive, as what these have in common then counts as noise.
///
/// A number is worse or better where the interval of its change lies beyond the tolerance and its
/// p, adjusted by Holm over all numbers of the comparison, is below kVerdictLevel. `tolerance` is
/// what is allowed on top: of a rate a change by that part of the trials, of anything else by that
/// part of the base's.
///
/// Scores of estimates, folders of `score` or their targets.csv, are compared by compare_scores.
///
/// Throws InputError for what cannot be read, for runs of different studies, a run and scores, and
/// for a measure that these have not.
Comparison compare_runs(const std::filesystem::path& base, const std::filesystem::path& now,
                        double tolerance, const std::vector<std::string>& measures = {});

}  // namespace sightline
