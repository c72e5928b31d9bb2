// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The comparator: plain RANSAC (Fischler, Bolles 1981). Three pairs drawn at random, their pose by
// Umeyama's method, the pairs within a distance counted; the best count wins, and Umeyama's method
// on those pairs, counted and fitted again as long as they grow, is the answer.
//
// Stop rule: k >= ln(1e-3) / ln(1 - w^3) with the share w of the best count so far, at most 100000.
// Distance: what none of n pairs of noise exceeds (orpe_limits.h) at the noise that is known; where
// it is not, 3 % of the span of the points in b, a number that somebody has to choose. It draws
// from a stream of its own that is always the same. Significant where more pairs agree than chance
// brings together: log10 of the expected number of such sets among outliers below -2 (a contrario,
// Moisan, Stival 2004).

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pose/orientation/consensus_answer.h"
#include "pose/orientation/methods.h"
#include "pose/orientation/orpe_limits.h"
#include "pose/orientation/robust_methods.h"

namespace sightline {
namespace {

using pair_consensus::PairSet;
using pair_consensus::Similarity;

constexpr std::uint64_t kMostDraws = 100000;
constexpr double kMissProbability = 1e-3;
constexpr double kUnknownDistance = 0.03;
constexpr int kMostRefits = 10;

std::optional<Similarity> umeyama_of(const PairSet& set, std::span<const int> indices) {
  std::vector<Eigen::Vector3d> in_a, in_b;
  std::vector<double> weights;
  for (const int index : indices) {
    const auto k = static_cast<std::size_t>(index);
    in_a.push_back(set.a[k]);
    in_b.push_back(set.b[k]);
    weights.push_back(set.inverse_variance[k]);
  }
  const PairMoments moments = pair_moments<double>(in_a, in_b, weights, set.estimates_scale);
  if (moments.status != OrientationStatus::kOk) return std::nullopt;
  const OrientationEstimate estimate =
      set.estimates_scale ? orient_by_umeyama_scaled(moments) : orient_by_umeyama(moments);
  if (estimate.status != OrientationStatus::kOk) return std::nullopt;
  return Similarity{estimate.b_from_a.rotation, estimate.b_from_a.translation, estimate.scale};
}

std::vector<int> pairs_within(const PairSet& set, const Similarity& map, double limit) {
  std::vector<int> within;
  for (int i = 0; i < set.n(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double square = (map * set.a[k] - set.b[k]).squaredNorm() * set.inverse_variance[k];
    if (square <= limit) within.push_back(i);
  }
  return within;
}

/// The most pairs that agree with the map of three.
std::vector<int> largest_agreement(const PairSet& set, double limit) {
  std::vector<int> best;
  double needed = static_cast<double>(kMostDraws);
  for (std::uint64_t draw = 0; static_cast<double>(draw) < needed; ++draw) {
    const std::vector<int> three = {pair_consensus::drawn_below(3 * draw, set.n()),
                                    pair_consensus::drawn_below(3 * draw + 1, set.n()),
                                    pair_consensus::drawn_below(3 * draw + 2, set.n())};
    if (three[0] == three[1] || three[0] == three[2] || three[1] == three[2]) continue;
    const auto map = umeyama_of(set, three);
    if (!map) continue;
    std::vector<int> within = pairs_within(set, *map, limit);
    if (within.size() <= best.size()) continue;
    best = std::move(within);
    const double share = static_cast<double>(best.size()) / set.n();
    const double hit = std::min(share * share * share, 1 - 1e-9);
    needed = std::min(needed, std::log(kMissProbability) / std::log1p(-hit));
  }
  return best;
}

std::vector<int> refitted(const PairSet& set, std::vector<int> agreeing, double limit) {
  for (int i = 0; i < kMostRefits; ++i) {
    const auto map = umeyama_of(set, agreeing);
    if (!map) break;
    std::vector<int> within = pairs_within(set, *map, limit);
    if (within.size() <= agreeing.size()) break;
    agreeing = std::move(within);
  }
  return agreeing;
}

/// ln of how many sets of k that agree to this distance chance makes among n outliers.
double log_false_alarms(const PairSet& set, double k, double limit) {
  const double n = set.n();
  const double ball = 4.0 / 3 * std::numbers::pi * std::pow(limit, 1.5) / set.volume;
  const auto log_binomial = [](double of, double some) {
    return std::lgamma(of + 1) - std::lgamma(some + 1) - std::lgamma(of - some + 1);
  };
  return std::log(n) + log_binomial(n, k) + log_binomial(k, 3) +
         (k - 3) * std::log(std::min(ball, 1.0));
}

}  // namespace

RobustAlignment align_by_ransac_umeyama(const MatchedPoints& points,
                                        const RobustAlignmentOptions& options) {
  const PairSet set = pair_consensus::prepare_pairs(points, options);
  if (set.status != OrientationStatus::kOk) return pair_consensus::failure(set, set.status);
  const double distance = kUnknownDistance * set.span;
  const double limit = set.sigma > 0 ? set.sigma * set.sigma *
                                           squared_distance_limit(options.false_alarm_rate, set.n())
                                     : distance * distance;
  const std::vector<int> agreeing = refitted(set, largest_agreement(set, limit), limit);
  const auto mixture = pair_consensus::certain_mixture(set, agreeing);
  if (!mixture) return pair_consensus::failure(set, OrientationStatus::kDegenerate);
  RobustAlignment alignment = pair_consensus::answer_of(points, set, *mixture);
  const auto kept = static_cast<double>(agreeing.size());
  alignment.is_significant = kept > 3 && log_false_alarms(set, kept, limit) < std::log(0.01);
  return alignment;
}

}  // namespace sightline
