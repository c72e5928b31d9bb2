// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Absolute orientation from pairs of which most may be wrong, by consensus. Three steps:
//
//   1. Search: maps that many pairs agree with, found by distances that are kept
//      (consensus_search.cpp).
//   2. Mixture: for each of the best maps the probability of every pair to be an inlier, the noise
//      and the weighted least-squares map, in turns (consensus_mixture.cpp).
//   3. Choice by the evidence of the pairs that are probably inliers, the map integrated: five
//   pairs
//      that agree badly do not win against four that agree well (consensus_choice.cpp,
//      consensus_evidence.cpp).
//
// Noise: known, or found (pose/robust_alignment.h says up to where). Three pairs are answered by
// their least squares, without anything to judge them by. The answer's covariance has the doubt
// about inliers in it; it is significant where the Bayes factor against "all pairs are outliers,
// uniform in the box of b" is above 100.
//
// Not taken up: outliers are held to be uniform. Those that all move together are another
// consensus, and the larger one wins.

#include "pose/orientation/consensus_answer.h"
#include "pose/orientation/consensus_choice.h"
#include "pose/orientation/robust_methods.h"

namespace sightline {

RobustAlignment align_by_consensus(const MatchedPoints& points,
                                   const RobustAlignmentOptions& options) {
  const pair_consensus::PairSet set = pair_consensus::prepare_pairs(points, options);
  if (set.status != OrientationStatus::kOk) return pair_consensus::failure(set, set.status);
  const auto best = pair_consensus::find_consensus(set);
  if (!best) return pair_consensus::failure(set, OrientationStatus::kDegenerate);
  RobustAlignment alignment = pair_consensus::answer_of(points, set, best->mixture);
  alignment.is_significant = best->log_evidence > pair_consensus::kSignificantLogEvidence;
  return alignment;
}

}  // namespace sightline
