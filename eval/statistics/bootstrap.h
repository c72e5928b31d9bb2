// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "eval/statistics/statistics.h"

namespace sightline {

/// The bias-corrected and accelerated bootstrap interval of the mean of finite values (Efron 1987;
/// Efron and Tibshirani 1993, section 14.3), 95 %, 2000 resamples. A single point where all values
/// are equal, NaN for fewer than two. Deviations: a resample that ties with the mean counts half
/// in the bias correction, as capped errors tie often; beyond 500 values it is BCa's analytic form,
/// ABC (DiCiccio and Efron, Biometrika 79, 1992; Efron and Tibshirani, section 14.4), which then
/// agrees within what 2000 resamples leave to chance, and costs nothing. Its standard error has
/// n - 1 where theirs has n.
Interval95 bca_mean_interval(std::span<const double> values, uint64_t seed,
                             std::string_view stream);

/// Up to so many values are resampled; of more the analytic form is taken.
constexpr size_t kMostValuesToResample = 500;

/// That analytic form of `n` values that are not all equal, from their mean and their sums of
/// squares and cubes about it.
Interval95 abc_mean_interval(double n, double mean, double squares, double cubes);

/// A number made of things that are drawn: their indices, some of them several times.
using ResampledNumber = std::function<double(std::span<const uint32_t> drawn)>;

/// The percentile interval of any number that is made of `count` things (Efron and Tibshirani 1993,
/// section 13.3), 95 %: for a difference of two quantiles or ratios of the same trials. 2000
/// resamples, of more than 2000 things fewer, down to 200, as the work is then too much and the
/// number's law is near the normal one. A resample of which there is no number is left out. NaN of
/// fewer than two things.
Interval95 bootstrap_interval(size_t count, uint64_t seed, std::string_view stream,
                              const ResampledNumber& number);

}  // namespace sightline
