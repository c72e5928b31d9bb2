// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/statistics/rms_ratio.h"

#include <cmath>

namespace sightline {

void RmsRatio::add(double numerator, double denominator) {
  ++count_;
  a2_ += numerator * numerator;
  b2_ += denominator * denominator;
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

}  // namespace sightline
