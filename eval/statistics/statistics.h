// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

namespace sightline {

/// Both ends of a 95 % interval; NaN where there is none.
using Interval95 = std::array<double, 2>;
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr Interval95 kNoInterval{kNoNumber, kNoNumber};

/// A number and its 95 % interval; NaN where nothing was measured.
struct Measured {
  double value = kNoNumber;
  Interval95 ci95 = kNoInterval;
};

/// What lies on either side of a 95 % interval.
constexpr double kTail95 = 0.025;

/// The quantile of the standard normal law below which 97.5 % lie: half the width of a 95 %
/// interval, in standard errors.
constexpr double kZ95 = 1.959963984540054;

/// A sum of squares that knows how many it holds.
struct MeanSquare {
  double sum = 0;
  int count = 0;

  void add(double value) {
    sum += value * value;
    ++count;
  }
  /// The root mean square; NaN of none.
  double root() const { return count > 0 ? std::sqrt(sum / count) : kNoNumber; }
};

/// The standard normal distribution function and its inverse (p in (0, 1)).
double normal_cdf(double z);
double normal_quantile(double p);

/// The value at fraction `p` in [0, 1] of the sorted values, linear between order statistics (type
/// 7 of Hyndman and Fan 1996). Values may be infinite; between a finite and an infinite one it is
/// infinite. NaN of no values.
double percentile(std::span<const double> values, double p);

/// The same of values, at least one, that are sorted already.
double percentile_of_sorted(std::span<const double> sorted, double p);

/// Which order statistics (from 0) bound the p-th quantile of n values with 95 % or more, whatever
/// their law (Conover 1999, section 3.2): -1 where no value is small enough, n where none is large
/// enough.
std::array<int64_t, 2> quantile_ranks(int64_t n, double p);

/// The 95 % interval of a rate of `count` of `trials` (Wilson 1927, without continuity correction;
/// Brown, Cai and DasGupta 2001, section 3.1.1). None of no trials.
Interval95 wilson_interval(int64_t count, int64_t trials);

/// The same interval of a rate that `trials` independent trials would have; they need not be a
/// whole number, but more than none. Rounding may put its ends a little outside of 0 and 1.
Interval95 wilson_interval_of_rate(double rate, double trials);

/// The 95 % interval of b - a of two values that are not paired, from their own intervals, which
/// need not be symmetric (MOVER: Zou and Donner, Statistics in Medicine 27, 2008, eq. 2; of Wilson
/// intervals it is Newcombe's method 10, 1998).
Interval95 difference_interval(double a, const Interval95& a_ci95, double b,
                               const Interval95& b_ci95);

/// How many values a relative half-width of `target` of the mean's 95 % interval needs, from a
/// pilot of n values with a mean and its interval (Cochran 1977, section 4.6, with the interval's
/// own half-width for z s / sqrt(n)). None where the pilot says nothing.
std::optional<int64_t> trials_for(double target, int64_t n, double mean, const Interval95& ci95);

}  // namespace sightline
