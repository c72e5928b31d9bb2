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
//      that agree badly do not win against four that agree well.
//
// Noise: known, or found (pose/robust_alignment.h says up to where). Three pairs are answered by
// their least squares, without anything to judge them by. The answer's covariance has the doubt
// about inliers in it; it is significant where the Bayes factor against "all pairs are outliers,
// uniform in the box of b" is above kSignificantOdds.
//
// Not taken up: outliers are held to be uniform. Those that all move together are another
// consensus, and the larger one wins.

#include <algorithm>
#include <cmath>
#include <limits>

#include "pose/orientation/consensus_answer.h"
#include "pose/orientation/consensus_mixture.h"
#include "pose/orientation/consensus_search.h"
#include "pose/orientation/robust_methods.h"

namespace sightline {
namespace {

using consensus::Mixture;
using consensus::PairSet;

/// Maps with less than this part of the best one's score are not looked at, if that is not of a few
/// pairs alone, of which fewer may agree better.
constexpr double kHopeless = 0.6;
constexpr double kFew = 8;
const double kLogSignificantOdds = std::log(100.0);

/// The mixture begins at a noise that is rather too large.
double start_sigma(const PairSet& set) {
  return set.sigma > 0 ? 3 * set.sigma
                       : std::min(consensus::consensus_radius(set) / 2.6, set.largest_sigma());
}

struct WeighedMixture {
  Mixture mixture;
  double log_evidence;
};

std::optional<WeighedMixture> best_mixture(const PairSet& set) {
  const int looked_at = std::min(set.n(), consensus::kMostSearched);
  std::optional<WeighedMixture> best;
  const std::vector<consensus::Hypothesis> hypotheses = consensus::search_maps(set);
  for (const consensus::Hypothesis& hypothesis : hypotheses) {
    const bool is_hopeless =
        hypotheses.front().score > kFew && hypothesis.score < kHopeless * hypotheses.front().score;
    if (is_hopeless) continue;
    const auto mixture = consensus::fit_mixture(set, hypothesis.map, start_sigma(set), looked_at);
    if (!mixture) continue;
    const double log_evidence = consensus::log_evidence(set, *mixture);
    if (!best || log_evidence > best->log_evidence) best = {*mixture, log_evidence};
  }
  if (!best || looked_at == set.n()) return best;
  // Now all of them.
  const auto whole =
      consensus::fit_mixture(set, best->mixture.map, 1.5 * best->mixture.sigma, set.n());
  if (!whole) return std::nullopt;
  return WeighedMixture{*whole, consensus::log_evidence(set, *whole)};
}

/// Three pairs, which nothing contradicts.
std::optional<WeighedMixture> fit_of_three(const PairSet& set) {
  const std::optional<Mixture> mixture = consensus::certain_mixture(set, std::vector<int>{0, 1, 2});
  if (!mixture) return std::nullopt;
  return WeighedMixture{*mixture, -std::numeric_limits<double>::infinity()};
}

}  // namespace

RobustAlignment align_by_consensus(const MatchedPoints& points,
                                   const RobustAlignmentOptions& options) {
  const PairSet set = consensus::prepare_pairs(points, options);
  if (set.status != OrientationStatus::kOk) return consensus::failure(set, set.status);
  const auto best = set.n() == 3 ? fit_of_three(set) : best_mixture(set);
  if (!best) return consensus::failure(set, OrientationStatus::kDegenerate);
  RobustAlignment alignment = consensus::answer_of(points, set, best->mixture);
  alignment.is_significant = best->log_evidence > kLogSignificantOdds;
  return alignment;
}

}  // namespace sightline
