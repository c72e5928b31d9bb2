// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sightline {

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

/// One side of it: how likely `only_second` is so many of both together, or more.
double mcnemar_p_of_more(int64_t only_first, int64_t only_second);

/// Fisher's exact test, two-sided, of two rates that are not paired: the tables with the same
/// margins that are as unlikely as this one or more (Agresti 2002, section 3.5.1).
double fisher_p(int64_t count_a, int64_t trials_a, int64_t count_b, int64_t trials_b);

/// Holm's step-down adjustment of p-values (Scandinavian Journal of Statistics 6, 1979): those
/// below a level then are the rejections that keep the chance of any false one below that level.
std::vector<double> holm_adjusted(std::span<const double> p_values);

}  // namespace sightline
