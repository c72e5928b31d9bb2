// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "eval/statistics/statistics.h"

namespace sightline {

/// The 95 % interval of a rate of `count` of `trials` that is given of every rate of a summary:
/// Wilson's but where one to three trials are not like the others. There its nearer end is that of
/// a Poisson law, as Wilson's is too far in and holds a rate of 0.18 / trials in 84 of 100 cases
/// (Brown, Cai and DasGupta, Statistical Science 16, 2001, section 4.1.1, "modified Wilson"; they
/// take two trials up to 50 of them, here it is three always). From 20 trials on
/// it holds in at least 92 of 100 cases, whatever the rate; of 3 to 15 trials in at least 87. None
/// of no trials.
Interval95 rate_interval(int64_t count, int64_t trials);

}  // namespace sightline
