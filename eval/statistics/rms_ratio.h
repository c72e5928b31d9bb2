// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "eval/statistics/statistics.h"

namespace sightline {

/// A ratio of root mean squares and what a 95 % interval needs: sums over the same trials.
class RmsRatio {
 public:
  void add(double numerator, double denominator);
  /// NaN of nothing, or over nothing.
  double value() const;
  double numerator_rms() const;
  double denominator_rms() const;
  /// By the delta method for the logarithm of a ratio of means of paired values (Casella and
  /// Berger 2002, example 5.5.27); none of fewer than two.
  Interval95 ci95() const;

 private:
  int64_t count_ = 0;
  double a2_ = 0, b2_ = 0;             // sums of squares
  double a4_ = 0, b4_ = 0, a2b2_ = 0;  // of fourth order
};

}  // namespace sightline
