// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pose/orientation/consensus_mixture.h"

namespace sightline::pair_consensus {

/// A mixture over all pairs of the set, as an answer in the units that were given: pose, residuals,
/// noise, covariance, and what became of each pair. Whether it is significant is left open.
RobustAlignment answer_of(const MatchedPoints& points, const PairSet& set, const Mixture& mixture);

/// What failed, with the pairs that were ignored.
RobustAlignment failure(const PairSet& set, OrientationStatus status);

/// Maps a mixture on the set that has these inliers and no doubt: their least squares. Noise that
/// is not known is what their residuals say. None where they do not determine a map.
std::optional<Mixture> certain_mixture(const PairSet& set, std::span<const int> inliers);

}  // namespace sightline::pair_consensus
