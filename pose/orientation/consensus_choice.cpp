// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/orientation/consensus_choice.h"

#include <algorithm>
#include <limits>

#include "pose/orientation/consensus_answer.h"
#include "pose/orientation/consensus_evidence.h"
#include "pose/orientation/consensus_search.h"

namespace sightline::pair_consensus {
namespace {

/// Maps with less than this part of the best one's score are not looked at, if that is not of a few
/// pairs alone, of which fewer may agree better.
constexpr double kHopeless = 0.6;
constexpr double kFew = 8;

/// Where the noise is not known, and what was found at first is not significant, the search is
/// repeated for so many times the noise that it was made for.
constexpr double kOtherNoises[] = {2.5, 0.2};

using Best = std::optional<WeighedMixture>;

/// The mixture about a map, begun at a noise that is rather too large, and freed of intruders.
Best weighed_mixture(const PairSet& set, const Similarity& map, double start_sigma, int n) {
  const auto mixture = fit_mixture(set, map, start_sigma, n);
  if (!mixture) return std::nullopt;
  const std::vector<int> inliers = probable_inliers(*mixture);
  const WeighedMixture found = {*mixture, log_evidence(set, inliers, n)};
  if (set.sigma > 0) return found;
  const std::vector<int> fewer = without_intruders(set, inliers, n);
  if (fewer.size() == inliers.size()) return found;
  const auto certain = certain_mixture(set, fewer);
  if (!certain) return found;
  const auto better = fit_mixture(set, certain->map, certain->sigma, n);
  if (!better) return found;
  const double evidence = log_evidence(set, probable_inliers(*better), n);
  return evidence > found.log_evidence ? WeighedMixture{*better, evidence} : found;
}

void keep_better(Best& best, const Best& other) {
  if (other && (!best || other->log_evidence > best->log_evidence)) best = other;
}

/// The best mixture on the first n pairs from a search at that noise.
Best best_from_search(const PairSet& set, double sigma, int n) {
  // The radius of consensus over the root of 3, and a little more.
  const double start_sigma =
      set.sigma > 0 ? 3 * sigma : std::min(consensus_radius(sigma) / 2.6, set.largest_sigma());
  Best best;
  const std::vector<Hypothesis> hypotheses = search_maps(set, sigma);
  for (const Hypothesis& hypothesis : hypotheses) {
    const double best_score = hypotheses.front().score;
    if (best_score > kFew && hypothesis.score < kHopeless * best_score) continue;
    keep_better(best, weighed_mixture(set, hypothesis.map, start_sigma, n));
  }
  return best;
}

Best consensus_of_many(const PairSet& set) {
  const int n = std::min(set.n(), kMostSearched);
  const double sigma = set.expected_sigma();
  Best best = best_from_search(set, sigma, n);
  for (const double factor : kOtherNoises) {
    if (set.sigma > 0 || (best && best->log_evidence > kSignificantLogEvidence)) break;
    keep_better(best, best_from_search(set, factor * sigma, n));
  }
  if (!best || n == set.n()) return best;
  // Now all of them.
  return weighed_mixture(set, best->mixture.map, 1.5 * best->mixture.sigma, set.n());
}

/// Three pairs, which nothing contradicts.
Best fit_of_three(const PairSet& set) {
  const std::optional<Mixture> mixture = certain_mixture(set, std::vector<int>{0, 1, 2});
  if (!mixture) return std::nullopt;
  return WeighedMixture{*mixture, -std::numeric_limits<double>::infinity()};
}

}  // namespace

std::optional<WeighedMixture> find_consensus(const PairSet& set) {
  return set.n() == 3 ? fit_of_three(set) : consensus_of_many(set);
}

}  // namespace sightline::pair_consensus
