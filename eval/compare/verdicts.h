// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "eval/compare/compare.h"
#include "eval/compare/measures.h"

namespace sightline {

/// p-values of one side each: that the new run's number is greater than the tolerance allows, and
/// that it is less.
struct Sides {
  double greater = 1;
  double less = 1;
};

/// Gives a difference, whose interval is known, its two-sided p-value and the verdict that it has
/// by itself: the interval must lie beyond `allowed`.
void set_sides(const Measure& measure, const Sides& sides, double allowed, Difference& difference);

/// The same of a number whose interval is that of the test itself.
void set_sides(const Measure& measure, const Sides& sides, Difference& difference);

/// The same of a number whose test knows no tolerance: the change must be beyond it.
void set_p(const Measure& measure, double two_sided, double allowed, Difference& difference);

/// How much of a change is allowed of a number that was `base`; changes by rounding always are.
double allowed_change(const Measure& measure, double tolerance, double base);

/// Adjusts the p-values by Holm over all cells, withdraws the verdicts that do not stand after it,
/// and gives each cell its own.
void judge(std::vector<CellDifference>& cells);

}  // namespace sightline
