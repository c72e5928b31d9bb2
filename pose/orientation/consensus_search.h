// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The search of pose/orientation/consensus.cpp for maps that many pairs agree with.
#pragma once

#include <vector>

#include "pose/orientation/consensus_pairs.h"

namespace sightline::pair_consensus {

/// A map that some pairs agree with.
struct Hypothesis {
  Similarity map;
  /// The sum over the pairs (of the first kMostSearched) of max(0, 1 - r^2 / radius^2).
  double score = 0;
};

/// The radius of consensus: the distance, for a pair of variance 1, at which one is no longer one
/// of many that agree.
double consensus_radius(double sigma);

/// The best maps that differ, the best first, for noise of about that much; none where no three
/// pairs that are not collinear keep their distances.
std::vector<Hypothesis> search_maps(const PairSet& set, double sigma);

}  // namespace sightline::pair_consensus
