// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Wilcoxon's signed-rank test: whether the middle of paired differences lies off zero, however far
// a few outliers lie. It needs no more than that without a change a difference is as likely to have
// one sign as the other, as it is where both of a pair were made alike.
#pragma once

#include <span>

#include "eval/statistics/statistics.h"

namespace sightline {

/// One side of the test (Wilcoxon, Biometrics Bulletin 1, 1945): how likely the ranks of the
/// positive differences sum up to so much. Zeros say nothing and are left out, differences of equal
/// size share their mean rank. Exact over all choices of signs up to 50 differences, beyond by the
/// normal law of the same mean and variance, which the shared ranks enter, with half a rank of
/// continuity correction. Infinite differences rank above all others. 1 of nothing.
double p_middle_above_zero(std::span<const double> differences);

/// The middle of finite differences, zeros among them: the median of the means of all pairs, each
/// difference with itself as well (Hodges and Lehmann, Annals of Mathematical Statistics 34, 1963),
/// and the 95 % interval of which the test rejects nothing within (Hollander, Wolfe and Chicken
/// 2014, section 3.3; beyond 50 differences by the normal law). No interval of fewer than six.
Measured middle_of(std::span<const double> differences);

}  // namespace sightline
