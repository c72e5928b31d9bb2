// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
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

}  // namespace sightline
