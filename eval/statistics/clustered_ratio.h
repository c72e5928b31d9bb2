// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "eval/statistics/statistics.h"

namespace sightline {

/// The ratio of two sums over trials, such as features found over features to be seen. Features of
/// one trial share its light, background and prior, so that the trial is what is drawn: the
/// variance is that of a ratio of means over clusters (Cochran, Sampling Techniques, 3rd ed. 1977,
/// eq. 6.13, with trials as the sample). Five sums, whatever the number of trials.
class ClusteredRatio {
 public:
  /// What one trial adds to the two sums.
  void add(double numerator, double denominator);
  double value() const;
  /// Symmetric, by the normal law; none of fewer than two trials.
  Measured measured() const;
  /// For a rate: Wilson's interval of as many independent draws as have the same variance, so that
  /// it stays within 0 and 1 and says something where nothing or everything happened.
  Measured rate() const;
  double denominator() const { return denominator_; }

 private:
  double variance() const;

  int64_t trials_ = 0;
  double numerator_ = 0, denominator_ = 0;
  double numerator2_ = 0, denominator2_ = 0, product_ = 0;
};

}  // namespace sightline
