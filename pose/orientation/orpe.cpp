// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// ORPE, outlier-removal by minimax (Zhao, Zhang, Zuo, Xu 2009; pose/solvers/orpe.cpp), for
// distances of points in place of pixels, and for any number of them. The paper removes the point
// that holds the largest residual as long as that lowers the minimax by a factor; among many pairs
// with many outliers it does not lower it by much. Here it begins at a consensus and asks for a
// maximal set of pairs that noise can explain: with the bound
//
//   t^2(k) = sigma^2 q,   P(chi2_3 > q) = 1 - (1 - rate)^(1/k),
//
// on the largest squared distance of k pairs,
//
//   1. K = the pairs within t^2(n) of the map of consensus;
//   2. while the exact minimax of K is above t^2(|K|), the most binding pair leaves K;
//   3. the nearest pair outside, within 9 t^2, joins if the minimax of K with it is at most
//      t^2(|K| + 1); until none does;
//   4. the answer is the least squares of K: the minimax map itself errs several times as much
//   among
//      many pairs, since it depends on seven of them.
//
// Noise that is not known is that of the consensus. Never leaves fewer than four pairs; three pairs
// are answered by their least squares.

#include <algorithm>
#include <cmath>

#include "pose/orientation/consensus_answer.h"
#include "pose/orientation/consensus_choice.h"
#include "pose/orientation/orpe_limits.h"
#include "pose/orientation/orpe_minimax.h"
#include "pose/orientation/robust_methods.h"

namespace sightline {
namespace {

using pair_consensus::PairSet;
using pair_consensus::Similarity;

constexpr std::size_t kLeastKept = 4;
/// Pairs beyond this many bounds are not tried for joining.
constexpr double kMostTriedLimits = 9;

/// The removal, as it goes on.
struct PairRemoval {
  const PairSet& set;
  double variance;
  double rate;
  std::vector<int> kept;
  DistanceMinimax minimax;

  double limit(std::size_t pairs) const {
    return variance * squared_distance_limit(rate, static_cast<int>(pairs));
  }
};

double square_of(const PairSet& set, const Similarity& map, int index) {
  const auto k = static_cast<std::size_t>(index);
  return (map * set.a[k] - set.b[k]).squaredNorm() * set.inverse_variance[k];
}

/// Step 1.
void keep_near(const Similarity& map, PairRemoval& removal) {
  const double limit = removal.limit(removal.set.a.size());
  for (int i = 0; i < removal.set.n(); ++i) {
    if (square_of(removal.set, map, i) <= limit) removal.kept.push_back(i);
  }
}

/// Step 2. False where what is left determines no map.
bool remove_binding(PairRemoval& removal) {
  while (true) {
    const auto minimax = minimise_largest_distance(removal.set, removal.kept);
    if (!minimax) return false;
    removal.minimax = *minimax;
    const bool is_explained = minimax->largest <= removal.limit(removal.kept.size());
    if (is_explained || removal.kept.size() <= kLeastKept) return true;
    removal.kept.erase(removal.kept.begin() + static_cast<std::ptrdiff_t>(minimax->most_binding()));
  }
}

/// Pairs outside that may join, with their squared distances.
std::vector<std::pair<double, int>> candidates(const PairRemoval& removal) {
  std::vector<std::pair<double, int>> all;
  const double limit = kMostTriedLimits * removal.limit(removal.kept.size() + 1);
  for (int i = 0; i < removal.set.n(); ++i) {
    if (std::binary_search(removal.kept.begin(), removal.kept.end(), i)) continue;
    const double square = square_of(removal.set, removal.minimax.map, i);
    if (square <= limit) all.emplace_back(square, i);
  }
  return all;
}

/// Step 3.
void let_join(PairRemoval& removal) {
  std::vector<int> tried;
  while (true) {
    std::vector<std::pair<double, int>> all = candidates(removal);
    std::erase_if(all, [&](const auto& one) {
      return std::find(tried.begin(), tried.end(), one.second) != tried.end();
    });
    if (all.empty()) return;
    const auto [square, index] = *std::min_element(all.begin(), all.end());
    tried.push_back(index);
    std::vector<int> more = removal.kept;
    more.insert(std::lower_bound(more.begin(), more.end(), index), index);
    if (square <= removal.minimax.largest) {
      removal.kept = more;
      continue;
    }
    const auto minimax = minimise_largest_distance(removal.set, more);
    if (!minimax || minimax->largest > removal.limit(more.size())) continue;
    removal.kept = more;
    removal.minimax = *minimax;
  }
}

}  // namespace

RobustAlignment align_by_orpe(const MatchedPoints& points, const RobustAlignmentOptions& options) {
  const PairSet set = pair_consensus::prepare_pairs(points, options);
  if (set.status != OrientationStatus::kOk) return pair_consensus::failure(set, set.status);
  const auto best = pair_consensus::find_consensus(set);
  if (!best) return pair_consensus::failure(set, OrientationStatus::kDegenerate);
  const double sigma = best->mixture.sigma;
  PairRemoval removal{set, sigma * sigma, options.false_alarm_rate, {}, {}};
  keep_near(best->mixture.map, removal);
  if (set.n() > 3 && removal.kept.size() >= kLeastKept) {
    if (!remove_binding(removal)) {
      return pair_consensus::failure(set, OrientationStatus::kDegenerate);
    }
    let_join(removal);
  }
  const auto mixture = pair_consensus::certain_mixture(set, removal.kept);
  if (!mixture) return pair_consensus::failure(set, OrientationStatus::kDegenerate);
  RobustAlignment alignment = pair_consensus::answer_of(points, set, *mixture);
  alignment.is_significant = best->log_evidence > pair_consensus::kSignificantLogEvidence;
  return alignment;
}

}  // namespace sightline
