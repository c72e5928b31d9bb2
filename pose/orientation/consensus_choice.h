// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The choice among the maps that the search found: steps 2 and 3 of pose/orientation/consensus.cpp.
#pragma once

#include <optional>

#include "pose/orientation/consensus_mixture.h"

namespace sightline::pair_consensus {

/// A mixture, and the evidence of its probable inliers (log_evidence).
struct WeighedMixture {
  Mixture mixture;
  double log_evidence = 0;
};

/// From here on chance can hardly have made it: odds of 100.
inline constexpr double kSignificantLogEvidence = 4.6;

/// The consensus of all pairs of the set, of which three need no search, and are never significant;
/// none where no four agree.
std::optional<WeighedMixture> find_consensus(const PairSet& set);

}  // namespace sightline::pair_consensus
