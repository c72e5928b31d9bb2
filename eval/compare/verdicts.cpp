// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/verdicts.h"

#include <algorithm>
#include <cmath>

#include "eval/statistics/significance.h"

namespace sightline {
namespace {

Verdict verdict_of(const Measure& measure, bool is_greater) {
  return is_greater == measure.number.is_more_better ? Verdict::kBetter : Verdict::kWorse;
}

}  // namespace

void set_sides(const Measure& measure, const Sides& sides, double allowed, Difference& difference) {
  difference.p = std::min(1.0, 2 * std::min(sides.greater, sides.less));
  if (difference.ci95[0] > allowed) difference.verdict = verdict_of(measure, true);
  if (difference.ci95[1] < -allowed) difference.verdict = verdict_of(measure, false);
}

void set_sides(const Measure& measure, const Sides& sides, Difference& difference) {
  difference.p = std::min(1.0, 2 * std::min(sides.greater, sides.less));
  difference.verdict = verdict_of(measure, sides.greater < sides.less);
}

void set_p(const Measure& measure, double two_sided, double allowed, Difference& difference) {
  const double change = difference.now - difference.base;
  if (!(std::abs(change) > allowed)) return;
  difference.p = two_sided;
  difference.verdict = verdict_of(measure, change > 0);
}

double allowed_change(const Measure& measure, double tolerance, double base) {
  // Changes by less are rounding, whatever their interval.
  constexpr double kRounding = 1e-9;
  const double part = std::max(tolerance, kRounding);
  return measure.number.is_rate() ? part : part * base;
}

void judge(std::vector<CellDifference>& cells) {
  std::vector<double> p_values;
  for (const CellDifference& cell : cells) {
    for (const Difference& difference : cell.differences) p_values.push_back(difference.p);
  }
  const std::vector<double> adjusted = holm_adjusted(p_values);
  size_t next = 0;
  for (CellDifference& cell : cells) {
    for (Difference& difference : cell.differences) {
      difference.p = adjusted[next++];
      if (difference.p >= kVerdictLevel) difference.verdict = Verdict::kUnchanged;
      if (difference.verdict == Verdict::kWorse) cell.verdict = Verdict::kWorse;
      if (difference.verdict == Verdict::kBetter && cell.verdict == Verdict::kUnchanged) {
        cell.verdict = Verdict::kBetter;
      }
    }
  }
}

}  // namespace sightline
