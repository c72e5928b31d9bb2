// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Inliers keep their distances from each other. The search goes through pairs i, and for each
//
//   1. lists the pairs that keep their distance from i (one pass of a kernel over at most 1024),
//   2. draws some j of them, and lists those that keep their distance from j as well,
//   3. takes of these the k that most others keep their distance from,
//   4. fits the map of i, j, k and those others, and scores it on all pairs.
//
// At noise of 1 % of the extent a wrong pair keeps its distance from another by chance in 11 of 100
// cases, so that four wrong pairs agree rarely and eight never: what reaches step 4 has mostly been
// decided by lengths alone. Where a scale is sought, j comes first: it says the scale, by which
// lengths are then compared.
//
// Stop rule: with a share e of inliers, and a share r of inliers among those near i, a visit of i
// with m draws of j finds them with probability p = q e (1 - (1 - r)^m), and the search ends when
// (1 - p)^visits <= eta for the best map so far. A set of up to kAllPairsBelow pairs is searched
// whole.

#include "pose/orientation/consensus_search.h"

#include <algorithm>
#include <cmath>

namespace sightline::consensus {
namespace {

/// Lengths may differ by this many standard deviations.
constexpr double kLengthSigmas = 3.3;
/// The radius of consensus in standard deviations of a coordinate.
constexpr double kRadiusSigmas = 4.5;
/// What noise is taken for that is not known, of the cube root of the volume.
constexpr double kGuessedSigma = 0.0107;
/// Pairs nearer to each other than this say nothing of the rotation; nearer than the other, nothing
/// of the scale.
constexpr double kLeastLength = 0.02;
constexpr double kLeastScaleLength = 0.15;
/// Up to here every i and every j is tried.
constexpr int kAllPairsBelow = 48;
constexpr int kDrawsOfJ = 8;
constexpr int kDrawsOfJWithScale = 16;
/// Of the pairs near i and j so many are tried as k.
constexpr int kMostTriedAsK = 24;
/// A clique must have this part of the largest one's size.
constexpr double kWorthLooking = 0.6;
constexpr std::size_t kMostHypotheses = 8;
constexpr int kPolishRounds = 3;
constexpr double kMissProbability = 1e-3;  // eta
constexpr double kHitProbability = 0.7;    // q
/// The least share of inliers that the search goes on for, besides that of four inliers.
constexpr double kLeastShare = 0.004;
constexpr int kLeastVisits = 6;

double noise_of(const PairSet& set) {
  return set.sigma > 0 ? set.sigma : kGuessedSigma * std::cbrt(set.volume);
}

/// What the search has and works in.
struct SearchState {
  explicit SearchState(const PairSet& pairs) : set(pairs) {}

  const PairSet& set;
  double sigma = noise_of(set);  ///< known or guessed
  double radius2 = std::pow(kRadiusSigmas * sigma, 2);
  int largest_clique = 0;
  double near_share = 0;  ///< how many of the pairs are near an i, mean of the visits
  int visits = 0;
  std::vector<Hypothesis> best;
  // Room to work in.
  kernel::PairRows block, near, shared;
  std::vector<int> flags, block_indices, near_indices, shared_indices, last_indices, members;

  double best_score() const { return best.empty() ? 0 : best.front().score; }
};

kernel::PairMap in_floats(const Similarity& map) {
  kernel::PairMap floats;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      floats.rows[4 * row + column] = static_cast<float>(map.scale * map.rotation(row, column));
    }
    floats.rows[4 * row + 3] = static_cast<float>(map.translation[row]);
  }
  return floats;
}

double score_of(const SearchState& state, const Similarity& map) {
  return kernel::consensus_score(state.block, in_floats(map), static_cast<float>(state.radius2));
}

/// Fitting what agrees and taking what agrees with that, until the score no longer rises.
Hypothesis polished(SearchState& state, const Similarity& start) {
  const PairSet& set = state.set;
  Hypothesis best = {start, score_of(state, start)};
  const int n = std::min(set.n(), kMostScored);
  for (int round = 0; round < kPolishRounds; ++round) {
    std::vector<int>& agreeing = state.last_indices;
    agreeing.clear();
    for (int i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double r2 = (best.map * set.a[k] - set.b[k]).squaredNorm();
      if (r2 <= state.radius2 * set.variance[k]) agreeing.push_back(i);
    }
    if (agreeing.size() < 3) break;
    const std::optional<Similarity> map = fit_pairs(set, agreeing);
    if (!map) break;
    const double score = score_of(state, *map);
    if (!(score > best.score)) break;
    best = {*map, score};
  }
  return best;
}

/// Whether two maps take the cloud to places that hardly differ.
bool are_alike(const SearchState& state, const Similarity& one, const Similarity& other) {
  const double radius = std::sqrt(state.radius2);
  for (const Eigen::Vector3d& x : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.5, 0, 0),
                                   Eigen::Vector3d(0, 0.5, 0), Eigen::Vector3d(0, 0, 0.5)}) {
    if (!((one * x - other * x).norm() < radius)) return false;
  }
  return true;
}

void keep_if_good(SearchState& state, const Hypothesis& found) {
  for (Hypothesis& kept : state.best) {
    if (!are_alike(state, kept.map, found.map)) continue;
    if (found.score > kept.score) kept = found;
    std::sort(state.best.begin(), state.best.end(),
              [](const Hypothesis& x, const Hypothesis& y) { return x.score > y.score; });
    return;
  }
  const auto place = std::find_if(state.best.begin(), state.best.end(),
                                  [&](const Hypothesis& kept) { return kept.score < found.score; });
  state.best.insert(place, found);
  if (state.best.size() > kMostHypotheses) state.best.pop_back();
}

/// Scores the map of state.members, which are indices into the block.
void try_members(SearchState& state) {
  const std::optional<Similarity> map = fit_pairs(state.set, state.members);
  if (!map) return;
  const double score = score_of(state, *map);
  const bool is_full = state.best.size() == kMostHypotheses;
  const double least = is_full ? state.best.back().score : 0;
  if (!(score > 0.75 * least)) return;
  if (score > 0.9 * state.best_score()) {
    keep_if_good(state, polished(state, *map));
  } else if (score > least) {
    keep_if_good(state, {*map, score});
  }
}

/// Steps 2 to 4 for one j, an index into state.near.
void visit_partner(SearchState& state, int i, int j, const kernel::PairTest& test) {
  kernel::compatible_pairs(state.near, kernel::pivot_at(state.near, static_cast<std::size_t>(j)),
                           test, state.flags, state.shared_indices);
  const int shared = static_cast<int>(state.shared_indices.size());
  const int worthwhile = std::max(1, static_cast<int>(kWorthLooking * state.largest_clique) - 2);
  if (shared < worthwhile) return;
  kernel::gather(state.near, state.shared_indices, state.shared);
  int best_k = 0;
  int most = -1;
  const int step = (shared + kMostTriedAsK - 1) / kMostTriedAsK;
  for (int k = 0; k < shared; k += step) {
    const auto pivot = kernel::pivot_at(state.shared, static_cast<std::size_t>(k));
    const int count = kernel::count_compatible(state.shared, pivot, test);
    if (count > most) {
      most = count;
      best_k = k;
    }
  }
  const int size = most + 3;
  if (size < kWorthLooking * state.largest_clique) return;
  state.largest_clique = std::max(state.largest_clique, size);
  kernel::compatible_pairs(state.shared,
                           kernel::pivot_at(state.shared, static_cast<std::size_t>(best_k)), test,
                           state.flags, state.last_indices);
  const auto in_block = [&](int in_near) {
    return state.near_indices[static_cast<std::size_t>(in_near)];
  };
  state.members = {i, in_block(j),
                   in_block(state.shared_indices[static_cast<std::size_t>(best_k)])};
  for (const int l : state.last_indices) {
    state.members.push_back(in_block(state.shared_indices[static_cast<std::size_t>(l)]));
  }
  try_members(state);
}

kernel::PairTest length_test(const SearchState& state, double scale, double spread) {
  const double tolerance = kLengthSigmas * state.sigma;
  kernel::PairTest test;
  test.scale = static_cast<float>(scale);
  test.tolerance2 = static_cast<float>(tolerance * tolerance);
  test.spread = static_cast<float>(spread);
  test.least_length2 = static_cast<float>(kLeastLength * kLeastLength);
  return test;
}

void find_near(SearchState& state, int i, const kernel::PairTest& test) {
  kernel::compatible_pairs(state.block, kernel::pivot_at(state.block, static_cast<std::size_t>(i)),
                           test, state.flags, state.near_indices);
  ++state.visits;
  state.near_share +=
      (static_cast<double>(state.near_indices.size()) / state.block.n - state.near_share) /
      state.visits;
  if (state.near_indices.size() >= 2) kernel::gather(state.block, state.near_indices, state.near);
}

/// A visit of i where the scale is 1.
void visit(SearchState& state, int i, std::uint64_t counter) {
  const kernel::PairTest test = length_test(state, 1, 0);
  find_near(state, i, test);
  const int near = static_cast<int>(state.near_indices.size());
  if (near < 2) return;
  if (state.set.n() <= kAllPairsBelow) {
    for (int j = 0; j < near; ++j) {
      if (state.near_indices[static_cast<std::size_t>(j)] > i) visit_partner(state, i, j, test);
    }
    return;
  }
  for (int draw = 0; draw < kDrawsOfJ; ++draw) {
    visit_partner(state, i,
                  drawn_below(counter * kDrawsOfJ + static_cast<std::uint64_t>(draw), near), test);
  }
}

/// i and j say the scale; what keeps its distance from i by that scale is near.
void visit_with_scale_of(SearchState& state, int i, int j) {
  const auto at = [](int index) { return static_cast<std::size_t>(index); };
  const double length_a = (state.set.a[at(j)] - state.set.a[at(i)]).norm();
  const double length_b = (state.set.b[at(j)] - state.set.b[at(i)]).norm();
  if (!(length_a >= kLeastScaleLength && length_b >= kLeastScaleLength)) return;
  const double variance = state.set.variance[at(i)] + state.set.variance[at(j)];
  const kernel::PairTest test =
      length_test(state, length_b / length_a, variance / (length_a * length_a));
  find_near(state, i, test);
  const auto here = std::find(state.near_indices.begin(), state.near_indices.end(), j);
  if (here == state.near_indices.end() || state.near_indices.size() < 2) return;
  visit_partner(state, i, static_cast<int>(here - state.near_indices.begin()), test);
}

void visit_with_scale(SearchState& state, int i, std::uint64_t counter) {
  const int block = static_cast<int>(state.block.n);
  if (state.set.n() <= kAllPairsBelow) {
    for (int j = i + 1; j < block; ++j) visit_with_scale_of(state, i, j);
    return;
  }
  for (int draw = 0; draw < kDrawsOfJWithScale; ++draw) {
    const int j =
        drawn_below(counter * kDrawsOfJWithScale + static_cast<std::uint64_t>(draw), block);
    visit_with_scale_of(state, i, j);
  }
}

/// How many visits the stop rule asks for, with the best map so far.
double needed_visits(const SearchState& state) {
  const double n = static_cast<double>(state.block.n);
  const double least = std::max(4.0, kLeastShare * n);
  const double inliers = std::clamp(state.best_score(), least, n);
  const double share = inliers / n;
  const bool with_scale = state.set.estimates_scale;
  const double near = with_scale ? n : std::max(state.near_share * n, inliers - 1);
  const int draws = with_scale ? kDrawsOfJWithScale : kDrawsOfJ;
  const double hit_of_draws = 1 - std::pow(1 - std::min((inliers - 1) / near, 1.0), draws);
  const double hit = kHitProbability * share * hit_of_draws;
  return std::max<double>(kLeastVisits, std::log(kMissProbability) / std::log1p(-hit));
}

void take_block(SearchState& state) {
  const int n = std::min(state.set.n(), kMostScored);
  state.block_indices.resize(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) state.block_indices[static_cast<std::size_t>(i)] = i;
  kernel::gather(state.set.rows, state.block_indices, state.block);
}

}  // namespace

double consensus_radius(const PairSet& set) {
  return kRadiusSigmas * noise_of(set);
}

std::vector<Hypothesis> search_maps(const PairSet& set) {
  SearchState state(set);
  take_block(state);
  const int n = static_cast<int>(state.block.n);
  for (std::uint64_t counter = 0;; ++counter) {
    if (set.n() <= kAllPairsBelow && counter >= state.block.n) break;
    if (set.n() > kAllPairsBelow && static_cast<double>(counter) >= needed_visits(state)) break;
    const int i = static_cast<int>(counter % static_cast<std::uint64_t>(n));
    if (set.estimates_scale) {
      visit_with_scale(state, i, counter);
    } else {
      visit(state, i, counter);
    }
  }
  return state.best;
}

}  // namespace sightline::consensus
