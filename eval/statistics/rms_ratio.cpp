// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics/rms_ratio.h"

#include <algorithm>
#include <cmath>

namespace sightline {

void RmsRatio::add(double numerator, double denominator) {
  const double a2 = numerator * numerator;
  const double b2 = denominator * denominator;
  ++count_;
  a2_ += a2;
  b2_ += b2;
  a4_ += a2 * a2;
  b4_ += b2 * b2;
  a2b2_ += a2 * b2;
}

double RmsRatio::numerator_rms() const {
  return count_ > 0 ? std::sqrt(a2_ / static_cast<double>(count_)) : kNoNumber;
}

double RmsRatio::denominator_rms() const {
  return count_ > 0 ? std::sqrt(b2_ / static_cast<double>(count_)) : kNoNumber;
}

double RmsRatio::value() const {
  return denominator_rms() > 0 ? numerator_rms() / denominator_rms() : kNoNumber;
}

Interval95 RmsRatio::ci95() const {
  const double ratio = value();
  if (count_ < 2 || !(ratio > 0)) return kNoInterval;
  const double n = static_cast<double>(count_);
  const double a = a2_ / n;
  const double b = b2_ / n;
  // The variance of x / a - y / b, whose mean is zero.
  const double variance = (a4_ / (a * a) - 2 * a2b2_ / (a * b) + b4_ / (b * b)) / (n - 1);
  const double half_width = kZ95 / 2 * std::sqrt(std::max(0.0, variance) / n);  // of log(ratio)
  return {ratio * std::exp(-half_width), ratio * std::exp(half_width)};
}

}  // namespace sightline
