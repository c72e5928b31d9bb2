// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sightline {

/// The square of the distance, for noise of 1 in each coordinate, that none of `pairs` pairs of
/// pure Gaussian noise exceeds with probability 1 - false_alarm_rate: P(chi2_3 > t^2) = 1 - (1 -
/// rate)^(1 / pairs). The rate is taken into [1e-12, 0.5].
double squared_distance_limit(double false_alarm_rate, int pairs);

}  // namespace sightline
