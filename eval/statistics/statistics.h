// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace sightline {

/// Both ends of a 95 % interval; NaN where there is none.
using Interval95 = std::array<double, 2>;
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr Interval95 kNoInterval{kNoNumber, kNoNumber};

/// Statistics of one error over all trials of a cell, failures among them. NaN where there are no
/// trials.
struct ErrorSummary {
  static constexpr double kNone = kNoNumber;
  double mean = kNone;                 ///< of the errors capped at `cap`, a failure counting as cap
  Interval95 mean_ci95 = kNoInterval;  ///< BCa bootstrap interval of that mean
  double median = kNone;  ///< a failure counting as infinite: infinite where half or more failed
  Interval95 median_ci95 = kNoInterval;  ///< of order statistics (quantile_ranks)
  double rms = kNone;                    ///< capped as the mean
  Interval95 rms_ci95 = kNoInterval;     ///< BCa of the mean square
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
  /// The p-th quantile as percentile() has it; NaN of nothing.
  double quantile(double p) const;
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
    Interval95 abc_mean_interval() const;
  };

  // The error of a rank from 0, from all of them sorted or, where there are too many, the bins.
  double value_at(std::span<const double> sorted, int64_t rank) const;
  double quantile_of(std::span<const double> sorted, double p) const;
  Interval95 quantile_interval(std::span<const double> sorted, double p) const;

  double cap_;
  Moments errors_;   // capped
  Moments squares_;  // of the capped errors
  int64_t capped_ = 0;
  std::vector<double> values_;  // not capped
  std::vector<int64_t> bins_;   // how many are in each, once there are too many values
};

/// The same of errors that are at hand.
ErrorSummary summarise(std::span<const double> errors, double cap, uint64_t seed,
                       std::string_view stream);

/// The bias-corrected and accelerated bootstrap interval of the mean of finite values (Efron 1987;
/// Efron and Tibshirani 1993, section 14.3), 95 %, 2000 resamples. A single point where all values
/// are equal, NaN for fewer than two. Deviations: a resample that ties with the mean counts half
/// in the bias correction, as capped errors tie often; beyond 500 values it is BCa's analytic form,
/// ABC (DiCiccio and Efron, Biometrika 79, 1992; Efron and Tibshirani, section 14.4), which then
/// agrees within what 2000 resamples leave to chance, and costs nothing. Its standard error has
/// n - 1 where theirs has n.
Interval95 bca_mean_interval(std::span<const double> values, uint64_t seed,
                             std::string_view stream);

/// The 95 % interval of a rate of `count` of `trials` (Wilson 1927, without continuity correction;
/// Brown, Cai and DasGupta 2001, section 3.1.1). None of no trials.
Interval95 wilson_interval(int64_t count, int64_t trials);

/// Which order statistics (from 0) bound the p-th quantile of n values with 95 % or more, whatever
/// their law (Conover 1999, section 3.2): -1 where no value is small enough, n where none is large
/// enough.
std::array<int64_t, 2> quantile_ranks(int64_t n, double p);

/// How many values a relative half-width of `target` of the mean's 95 % interval needs, from a
/// pilot of n values with a mean and its interval (Cochran 1977, section 4.6, with the interval's
/// own half-width for z s / sqrt(n)). None where the pilot says nothing.
std::optional<int64_t> trials_for(double target, int64_t n, double mean, const Interval95& ci95);

/// One side of a paired comparison by the randomisation test (Fisher 1935; Pitman 1937): the share
/// of the 2^n choices of the differences' signs whose sum is as great as theirs. Exact up to 16
/// values, beyond by the normal law of the same mean, 0, and variance, the sum of squares. It stays
/// honest where a few trials flip between success and failure, of which a bootstrap makes too much.
/// 1 of nothing.
double p_mean_above_zero(std::span<const double> differences);

/// McNemar's test of two paired rates, exact, two-sided: of the trials in which only the first or
/// only the second failed, how likely so uneven a division is (McNemar 1947; the binomial test of
/// Conover 1999, section 3.5).
double mcnemar_p(int64_t only_first, int64_t only_second);

/// Fisher's exact test, two-sided, of two rates that are not paired: the tables with the same
/// margins that are as unlikely as this one or more (Agresti 2002, section 3.5.1).
double fisher_p(int64_t count_a, int64_t trials_a, int64_t count_b, int64_t trials_b);

/// Holm's step-down adjustment of p-values (Scandinavian Journal of Statistics 6, 1979): those
/// below a level then are the rejections that keep the chance of any false one below that level.
std::vector<double> holm_adjusted(std::span<const double> p_values);

/// The 95 % interval of b - a of two values that are not paired, from their own intervals, which
/// need not be symmetric (MOVER: Zou and Donner, Statistics in Medicine 27, 2008, eq. 2; of Wilson
/// intervals it is Newcombe's method 10, 1998).
Interval95 difference_interval(double a, const Interval95& a_ci95, double b,
                               const Interval95& b_ci95);

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

/// The value at fraction `p` in [0, 1] of the sorted values, linear between order statistics (type
/// 7 of Hyndman and Fan 1996). Values may be infinite; between a finite and an infinite one it is
/// infinite. NaN of no values.
double percentile(std::span<const double> values, double p);

/// The standard normal distribution function and its inverse (p in (0, 1)).
double normal_cdf(double z);
double normal_quantile(double p);

}  // namespace sightline
