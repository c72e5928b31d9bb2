// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics/statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>

namespace sightline {

double normal_cdf(double z) {
  return std::erfc(-z / std::numbers::sqrt2) / 2;
}

double normal_quantile(double p) {
  return boost::math::quantile(boost::math::normal(), p);
}

double percentile_of_sorted(std::span<const double> sorted, double p) {
  const double position = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<size_t>(position);
  const double fraction = position - static_cast<double>(below);
  // Infinity minus infinity is no number: ask for the difference only where it counts.
  if (fraction == 0 || sorted[below] == sorted[below + 1]) return sorted[below];
  return sorted[below] + fraction * (sorted[below + 1] - sorted[below]);
}

double percentile(std::span<const double> values, double p) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  return percentile_of_sorted(sorted, p);
}

std::array<int64_t, 2> quantile_ranks(int64_t n, double p) {
  const boost::math::binomial below(static_cast<double>(n), p);
  // The chance that at most k of the values are below the quantile.
  const auto at_most = [&](int64_t k) { return boost::math::cdf(below, static_cast<double>(k)); };
  // The least k in [0, n] with at_most(k) > level.
  const auto first_above = [&](double level) {
    int64_t low = 0;
    int64_t high = n;
    while (low < high) {
      const int64_t middle = (low + high) / 2;
      at_most(middle) > level ? high = middle : low = middle + 1;
    }
    return low;
  };
  return {first_above(kTail95) - 1, first_above(1 - kTail95)};
}

Interval95 wilson_interval_of_rate(double rate, double trials) {
  const double z2 = kZ95 * kZ95;
  const double middle = (rate + z2 / (2 * trials)) / (1 + z2 / trials);
  const double half_width =
      kZ95 / (1 + z2 / trials) * std::sqrt(rate * (1 - rate) / trials + z2 / (4 * trials * trials));
  return {middle - half_width, middle + half_width};
}

Interval95 wilson_interval(int64_t count, int64_t trials) {
  if (trials <= 0) return kNoInterval;
  const double n = static_cast<double>(trials);
  const Interval95 ends = wilson_interval_of_rate(static_cast<double>(count) / n, n);
  // Rounding must not put none or all outside.
  return {count == 0 ? 0 : ends[0], count == trials ? 1 : ends[1]};
}

Interval95 difference_interval(double a, const Interval95& a_ci95, double b,
                               const Interval95& b_ci95) {
  return {b - a - std::hypot(b - b_ci95[0], a_ci95[1] - a),
          b - a + std::hypot(b_ci95[1] - b, a - a_ci95[0])};
}

std::optional<int64_t> trials_for(double target, int64_t n, double mean, const Interval95& ci95) {
  const double relative = (ci95[1] - ci95[0]) / 2 / mean;
  if (!(mean > 0) || !std::isfinite(relative)) return std::nullopt;
  return static_cast<int64_t>(std::ceil(static_cast<double>(n) * std::pow(relative / target, 2)));
}

}  // namespace sightline
