// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

namespace sightline {

/// Statistics of one error over all trials of a cell, failures among them. NaN where there are no
/// trials.
struct ErrorSummary {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  double mean = kNone;  ///< of the errors capped at `cap`, a failure counting as cap
  std::array<double, 2> mean_ci95{kNone, kNone};  ///< BCa bootstrap interval of that mean
  double median = kNone;  ///< a failure counting as infinite: infinite where half or more failed
  double rms = kNone;     ///< capped as the mean
  double p90 = kNone;     ///< as the median
  int capped = 0;         ///< trials at the cap or beyond, failures among them
};

/// Summarises errors; a failed trial's error is infinity (never NaN: those are a program error and
/// count as infinite). `stream` names the bootstrap's random stream, so that results repeat.
ErrorSummary summarise(std::span<const double> errors, double cap, uint64_t seed,
                       std::string_view stream);

/// The bias-corrected and accelerated bootstrap interval of the mean of finite values (Efron 1987;
/// Efron and Tibshirani 1993, section 14.3), 95 %, 2000 resamples. A single point where all values
/// are equal, NaN for fewer than two. Deviations: a resample that ties with the mean counts half
/// in the bias correction, as capped errors tie often; beyond 500 values it is BCa's analytic form,
/// ABC (DiCiccio and Efron, Biometrika 79, 1992; Efron and Tibshirani, section 14.4), which then
/// agrees within what 2000 resamples leave to chance, and costs nothing. Its standard error has
/// n - 1 where theirs has n.
std::array<double, 2> bca_mean_interval(std::span<const double> values, uint64_t seed,
                                        std::string_view stream);

/// The value at fraction `p` in [0, 1] of the sorted values, linear between order statistics (type
/// 7 of Hyndman and Fan 1996). Values may be infinite; between a finite and an infinite one it is
/// infinite. NaN of no values.
double percentile(std::span<const double> values, double p);

/// The standard normal distribution function and its inverse (p in (0, 1); Acklam's rational
/// approximation with one Halley step, absolute error under 1e-13).
double normal_cdf(double z);
double normal_quantile(double p);

}  // namespace sightline
