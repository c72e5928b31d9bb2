// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics/clustered_ratio.h"

#include <algorithm>
#include <cmath>

namespace sightline {

void ClusteredRatio::add(double numerator, double denominator) {
  ++trials_;
  numerator_ += numerator;
  denominator_ += denominator;
  numerator2_ += numerator * numerator;
  denominator2_ += denominator * denominator;
  product_ += numerator * denominator;
}

double ClusteredRatio::value() const {
  return denominator_ > 0 ? numerator_ / denominator_ : kNoNumber;
}

// Sum of (y - R x)^2 over the trials, over (sum of x)^2, times n / (n - 1).
double ClusteredRatio::variance() const {
  const double ratio = value();
  const double squares = numerator2_ - 2 * ratio * product_ + ratio * ratio * denominator2_;
  const auto n = static_cast<double>(trials_);
  return std::max(0.0, squares) / (denominator_ * denominator_) * n / (n - 1);
}

Measured ClusteredRatio::measured() const {
  Measured out{value(), kNoInterval};
  if (trials_ < 2 || !(denominator_ > 0)) return out;
  const double half = kZ95 * std::sqrt(variance());
  out.ci95 = {out.value - half, out.value + half};
  return out;
}

Measured ClusteredRatio::rate() const {
  Measured out = measured();
  if (std::isnan(out.ci95[0])) return out;
  const double p = out.value;
  const double spread = variance();
  // Never more than the observations there are: clusters may seem to differ less than chance.
  const double n = spread > 0 ? std::min(denominator_, p * (1 - p) / spread)
                              : std::min(denominator_, double(trials_));
  const Interval95 ends = wilson_interval_of_rate(p, n);
  out.ci95 = {std::max(0.0, ends[0]), std::min(1.0, ends[1])};
  return out;
}

}  // namespace sightline
