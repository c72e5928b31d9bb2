// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The evidence by which pose/orientation/consensus.cpp chooses among sets of inliers.
#pragma once

#include <span>
#include <vector>

#include "pose/orientation/consensus_mixture.h"

namespace sightline::pair_consensus {

/// How many times more probable it is that exactly these of the first n pairs agree than that all
/// of them are outliers: the logarithm of the Bayes factor, with the map and, where it is not
/// known, the noise integrated. Minus infinity where they do not determine a map.
double log_evidence(const PairSet& set, std::span<const int> inliers, int n);

/// The pairs with a probability above one half.
std::vector<int> probable_inliers(const Mixture& mixture);

/// The set of the most evidence that is reached by leaving out one pair after another; as it is,
/// where it has more than a few. One pair that is off by a few times the noise, where that is not
/// known, makes the noise look so large that it belongs.
std::vector<int> without_intruders(const PairSet& set, std::vector<int> inliers, int n);

}  // namespace sightline::pair_consensus
