// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics/rate_interval.h"

#include <array>

namespace sightline {
namespace {

// The mean of a Poisson law of which as many or more come in 5 of 100 cases: half the 5 % quantile
// of chi squared with twice as many degrees of freedom.
constexpr std::array<double, 4> kLeastMeans = {0, 0.0512932944, 0.3553615109, 0.8176914457};

bool is_rare(int64_t count, int64_t trials) {
  return count >= 1 && count < static_cast<int64_t>(kLeastMeans.size()) && 2 * count < trials;
}

}  // namespace

Interval95 rate_interval(int64_t count, int64_t trials) {
  Interval95 ends = wilson_interval(count, trials);
  const double n = static_cast<double>(trials);
  const int64_t others = trials - count;
  if (is_rare(count, trials)) ends[0] = kLeastMeans[static_cast<size_t>(count)] / n;
  if (is_rare(others, trials)) ends[1] = 1 - kLeastMeans[static_cast<size_t>(others)] / n;
  return ends;
}

}  // namespace sightline
