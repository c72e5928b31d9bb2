// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "eval/statistics/statistics.h"

namespace sightline {

/// Statistics of one error over all trials of a cell, failures among them. NaN where there are no
/// trials.
struct ErrorSummary {
  static constexpr double kNone = kNoNumber;
  double mean = kNone;  ///< of the errors capped at `cap`, a failure counting as cap
  /// BCa bootstrap interval of that mean, its upper end at least that of the same errors with one
  /// more of the greatest: of a hundred trials the next errs more than all in one case of a
  /// hundred, and nothing of them says by how much. Without it the interval held 83 to 87 of 100
  /// times where two trials of a hundred err by far; with it 90. Never
  /// above the cap, which no mean can exceed.
  Interval95 mean_ci95 = kNoInterval;
  /// The same without that error: its width falls with the root of the number of trials.
  Interval95 resampled_mean_ci95 = kNoInterval;
  double median = kNone;  ///< a failure counting as infinite: infinite where half or more failed
  Interval95 median_ci95 = kNoInterval;  ///< of order statistics (quantile_ranks)
  double rms = kNone;                    ///< capped as the mean
  Interval95 rms_ci95 = kNoInterval;     ///< none: what of a mean square holds is RmsRatio's matter
  double p90 = kNone;                    ///< as the median
  Interval95 p90_ci95 = kNoInterval;
  int64_t capped = 0;  ///< trials at the cap or beyond, failures among them
};

/// Takes the errors of a cell one by one, in the order of the trials, and summarises them. Beyond
/// `kMostValuesKept` of them its memory no longer grows: means and their intervals stay as they
/// are, of moments, but percentiles and their intervals are then right to 0.1 %.
class ErrorStatistics {
 public:
  static constexpr size_t kMostValuesKept = 100'000;

  explicit ErrorStatistics(double cap) : cap_(cap) {}
  /// A failed trial's error is infinity (never NaN: those are a program error and count as
  /// infinite).
  void add(double error);
  /// `stream` names the bootstrap's random stream, so that results repeat.
  ErrorSummary summary(uint64_t seed, std::string_view stream) const;
  /// The mean of the capped numbers and its BCa interval, of numbers of any sign.
  Measured mean_of(uint64_t seed, std::string_view stream) const;
  /// The p-th quantile as percentile() has it; NaN of nothing.
  double quantile(double p) const;
  /// The median and its interval, as summary() has them.
  Measured median() const;
  /// The mean of the capped errors; NaN of nothing.
  double mean() const { return errors_.count > 0 ? errors_.mean : kNoNumber; }
  int64_t count() const { return errors_.count; }

 private:
  // Sums about the mean, updated one by one (Pebay 2008, Sandia report 2008-6212).
  struct Moments {
    int64_t count = 0;
    double mean = 0;
    double squares = 0;
    double cubes = 0;
    double least = std::numeric_limits<double>::infinity();
    double greatest = -std::numeric_limits<double>::infinity();
    void add(double value);
    Interval95 mean_interval() const;
  };

  // The error of a rank from 0, from all of them sorted or, where there are too many, the bins.
  double value_at(std::span<const double> sorted, int64_t rank) const;
  double quantile_of(std::span<const double> sorted, double p) const;
  Interval95 quantile_interval(std::span<const double> sorted, double p) const;

  double cap_;
  Moments errors_;   // capped
  Moments squares_;  // of the capped errors, whose mean alone is asked for
  int64_t capped_ = 0;
  std::vector<double> values_;  // not capped
  std::vector<int64_t> bins_;   // how many are in each, once there are too many values
};

/// The same of errors that are at hand.
ErrorSummary summarise(std::span<const double> errors, double cap, uint64_t seed,
                       std::string_view stream);

}  // namespace sightline
