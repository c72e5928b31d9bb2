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
#include "pose/orientation/consensus_evidence.h"
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

/// Where the noise is not known, and what was found at first is not significant, the search is
/// repeated for so many times the noise that it was made for.
constexpr double kOtherNoises[] = {2.5, 0.2};

struct WeighedMixture {
  Mixture mixture;
  double log_evidence = 0;
};

using Best = std::optional<WeighedMixture>;

/// The mixture about a map, begun at a noise that is rather too large, and freed of intruders.
Best weighed_mixture(const PairSet& set, const consensus::Similarity& map, double start_sigma,
                     int n) {
  const auto mixture = consensus::fit_mixture(set, map, start_sigma, n);
  if (!mixture) return std::nullopt;
  const std::vector<int> inliers = consensus::probable_inliers(*mixture);
  const WeighedMixture found = {*mixture, consensus::log_evidence(set, inliers, n)};
  if (set.sigma > 0) return found;
  const std::vector<int> fewer = consensus::without_intruders(set, inliers, n);
  if (fewer.size() == inliers.size()) return found;
  const auto certain = consensus::certain_mixture(set, fewer);
  if (!certain) return found;
  const auto better = consensus::fit_mixture(set, certain->map, certain->sigma, n);
  if (!better) return found;
  const double evidence = consensus::log_evidence(set, consensus::probable_inliers(*better), n);
  return evidence > found.log_evidence ? WeighedMixture{*better, evidence} : found;
}

void keep_better(Best& best, const Best& other) {
  if (other && (!best || other->log_evidence > best->log_evidence)) best = other;
}

/// The best mixture on the first n pairs from a search at that noise.
Best best_from_search(const PairSet& set, double sigma, int n) {
  // The radius of consensus over the root of 3, and a little more.
  const double start_sigma =
      set.sigma > 0 ? 3 * sigma
                    : std::min(consensus::consensus_radius(sigma) / 2.6, set.largest_sigma());
  Best best;
  const std::vector<consensus::Hypothesis> hypotheses = consensus::search_maps(set, sigma);
  for (const consensus::Hypothesis& hypothesis : hypotheses) {
    const double best_score = hypotheses.front().score;
    if (best_score > kFew && hypothesis.score < kHopeless * best_score) continue;
    keep_better(best, weighed_mixture(set, hypothesis.map, start_sigma, n));
  }
  return best;
}

Best best_mixture(const PairSet& set) {
  const int n = std::min(set.n(), consensus::kMostSearched);
  const double sigma = set.expected_sigma();
  Best best = best_from_search(set, sigma, n);
  for (const double factor : kOtherNoises) {
    if (set.sigma > 0 || (best && best->log_evidence > kLogSignificantOdds)) break;
    keep_better(best, best_from_search(set, factor * sigma, n));
  }
  if (!best || n == set.n()) return best;
  // Now all of them.
  return weighed_mixture(set, best->mixture.map, 1.5 * best->mixture.sigma, set.n());
}

/// Three pairs, which nothing contradicts.
Best fit_of_three(const PairSet& set) {
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
