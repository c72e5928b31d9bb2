// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/orientation/orpe_limits.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sightline {
namespace {

/// P(chi2_3 > x).
double tail_of_chi2_3(double x) {
  return std::erfc(std::sqrt(x / 2)) + std::sqrt(2 * x / std::numbers::pi) * std::exp(-x / 2);
}

}  // namespace

double squared_distance_limit(double false_alarm_rate, int pairs) {
  const double rate = std::clamp(false_alarm_rate, 1e-12, 0.5);
  const double tail = -std::expm1(std::log1p(-rate) / std::max(pairs, 1));
  double low = 0;
  double high = 1000;  // its tail is below any that is asked for
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (tail_of_chi2_3(middle) > tail ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace sightline
