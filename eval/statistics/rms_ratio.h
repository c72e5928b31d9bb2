// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "eval/statistics/statistics.h"

namespace sightline {

/// A ratio of root mean squares over the same trials. It has no interval: squares of errors have so
/// heavy a tail that a sample of a hundred does not tell how far its own ratio may be off (by the
/// delta method, in logarithms, 95 % held 81 % of the time in studies, and 14 % in the worst cell).
class RmsRatio {
 public:
  void add(double numerator, double denominator);
  /// NaN of nothing, or over nothing.
  double value() const;
  double numerator_rms() const;
  double denominator_rms() const;

 private:
  int64_t count_ = 0;
  double a2_ = 0, b2_ = 0;  // sums of squares
};

}  // namespace sightline
