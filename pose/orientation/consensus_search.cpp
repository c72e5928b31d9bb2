// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Inliers keep their distances from each other. The search goes through pairs i, and for each
//
//   1. lists the pairs that keep their distance from i (one pass of a kernel over at most 1024),
//   2. draws some j of them, and lists those that keep their distance from j as well,
//   3. takes of these the k that most others keep their distance from,
//   4. fits the map of i, j, k and those others that agree with it, and scores it on all pairs.
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
#include <array>
#include <cmath>

namespace sightline::pair_consensus {
namespace {

/// Lengths may differ by this many standard deviations.
constexpr double kLengthSigmas = 3.3;
/// The radius of consensus in standard deviations of a coordinate.
constexpr double kRadiusSigmas = 4.5;
/// Pairs nearer to each other than this, in units or in tolerances, say nothing of the rotation,
/// and what keeps its distance from the one keeps it from the other; nearer than the last, nothing
/// of the scale.
constexpr double kLeastLength = 0.01;
constexpr double kLeastLengthTolerances = 2;
constexpr double kLeastScaleLength = 0.15;
/// Up to here every i and every j is tried.
constexpr int kAllPairsBelow = 48;
/// So many j are drawn for an i; fewer where one of them is likely to do.
constexpr int kDrawsOfJ = 8;
constexpr int kLeastDrawsOfJ = 2;
constexpr int kDrawsOfJWithScale = 16;
/// Of the pairs near i and j so many are tried as k.
constexpr int kMostTriedAsK = 24;
/// Of more pairs near i so many are looked at.
constexpr std::size_t kMostNear = 192;
/// Where the best map has many inliers, so many of them are enough to look for in a window of the
/// pairs.
constexpr double kInliersInWindow = 24;
constexpr std::size_t kLeastWindow = 128;
/// That many pairs at least must agree: a fourth, and this part of what is expected of the best
/// map.
constexpr int kLeastAgreeing = 4;
constexpr double kWorthLooking = 0.4;
/// A map that has less than this part of the best one's score on kFirstLook pairs gets no second
/// look, if so many of them would be expected.
constexpr double kWorthSecondLook = 0.35;
constexpr std::size_t kFirstLook = 256;
constexpr double kExpectedAtFirstLook = 12;
/// Up to this size the next best k is tried as well.
constexpr int kSmallClique = 12;
/// A map of this part of the best one's score may become the best.
constexpr double kGood = 0.8;
/// Where this share of all pairs agrees, one j is enough for an i.
constexpr double kPlenty = 0.1;
constexpr std::size_t kMostHypotheses = 8;
/// Pairs agree with a map of three pairs, which is inexact, within so many radii of consensus.
constexpr double kWidening = 2;
constexpr int kPolishRounds = 3;
constexpr double kMissProbability = 1e-3;  // eta
constexpr double kHitProbability = 0.8;    // q
/// The least share of inliers that the search goes on for, besides that of four inliers.
constexpr double kLeastShare = 0.004;
constexpr int kLeastVisits = 6;

/// What the search has and works in.
struct SearchState {
  SearchState(const PairSet& pairs, double noise) : set(pairs), sigma(noise) {}

  const PairSet& set;
  double sigma;
  double radius2 = std::pow(consensus_radius(sigma), 2);
  kernel::PairWindow window;  ///< where j and k are sought
  int least_clique = 0;       ///< that is worth looking at
  int draws = kDrawsOfJ;
  double near_share = 0;  ///< how many of the pairs are near an i, mean of the visits
  int visits = 0;
  std::vector<Hypothesis> best;
  // Room to work in.
  kernel::PairRows near, shared;
  std::vector<int> flags, near_indices, shared_indices, last_indices, members;

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

double score_within(const SearchState& state, const Similarity& map,
                    const kernel::PairWindow& window) {
  return kernel::consensus_score(state.set.rows, window, in_floats(map),
                                 static_cast<float>(state.radius2));
}

double score_of(const SearchState& state, const Similarity& map) {
  return score_within(state, map, kernel::all_of(state.set.rows));
}

/// Whether a look at some of the pairs shows that a map is far from being the best.
bool is_bad_at_first_look(const SearchState& state, const Similarity& map) {
  const double n = static_cast<double>(state.set.rows.n);
  const double expected = state.best_score() * (kFirstLook / n);
  if (expected < kExpectedAtFirstLook || 2 * kFirstLook > n) return false;
  return score_within(state, map, {0, kFirstLook}) < kWorthSecondLook * expected;
}

/// Fitting what agrees and taking what agrees with that, until the score no longer rises.
Hypothesis polished(SearchState& state, const Similarity& start) {
  const PairSet& set = state.set;
  Hypothesis best = {start, score_of(state, start)};
  const int n = std::min(set.n(), kMostSearched);
  for (int round = 0; round < kPolishRounds; ++round) {
    std::vector<int>& agreeing = state.last_indices;
    agreeing.clear();
    for (int i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double r2 = (best.map * set.a[k] - set.b[k]).squaredNorm();
      if (r2 * set.inverse_variance[k] <= state.radius2) agreeing.push_back(i);
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

/// The map of i, j and k, the first of state.members, which the others refine that agree with it:
/// what keeps its distance from the three may lie on the wrong side of them. None where too few
/// agree.
std::optional<Similarity> map_of_members(SearchState& state) {
  const PairSet& set = state.set;
  const std::optional<Similarity> map = fit_pairs(set, std::span(state.members).first(3));
  if (!map) return std::nullopt;
  std::vector<int>& agreeing = state.last_indices;
  agreeing.clear();
  const double limit = kWidening * kWidening * state.radius2;
  for (const int index : state.members) {
    const auto k = static_cast<std::size_t>(index);
    const double r2 = (*map * set.a[k] - set.b[k]).squaredNorm();
    if (r2 * set.inverse_variance[k] <= limit) agreeing.push_back(index);
  }
  if (static_cast<int>(agreeing.size()) < state.least_clique) return std::nullopt;
  return fit_pairs(set, agreeing);
}

/// Scores the map of state.members. Whether that settles i: so many agree with a map about as good
/// as the best that other j would lead to the same.
bool try_members(SearchState& state) {
  const std::optional<Similarity> map = map_of_members(state);
  if (!map || is_bad_at_first_look(state, *map)) return false;
  const double score = score_of(state, *map);
  const bool is_full = state.best.size() == kMostHypotheses;
  const double least = is_full ? state.best.back().score : 0;
  const bool is_good = score > kGood * state.best_score();
  if (is_good) {
    keep_if_good(state, polished(state, *map));
  } else if (score > least) {
    keep_if_good(state, {*map, score});
  }
  return is_good && score > kPlenty * static_cast<double>(state.set.rows.n);
}

/// i, j, k and what keeps its distance from all three become state.members; j is an index into
/// state.near, k one into state.shared.
void take_clique(SearchState& state, int i, int j, int k, const kernel::PairTest& test) {
  const auto at = [](const std::vector<int>& list, int index) {
    return list[static_cast<std::size_t>(index)];
  };
  kernel::compatible_pairs(state.shared, kernel::all_of(state.shared),
                           kernel::pivot_at(state.shared, static_cast<std::size_t>(k)), test,
                           state.flags, state.last_indices);
  state.members = {i, at(state.near_indices, j),
                   at(state.near_indices, at(state.shared_indices, k))};
  for (const int l : state.last_indices) {
    state.members.push_back(at(state.near_indices, at(state.shared_indices, l)));
  }
}

/// Steps 2 to 4 for one j, an index into state.near. Whether that settles i.
bool visit_partner(SearchState& state, int i, int j, const kernel::PairTest& test) {
  kernel::compatible_pairs(state.near, kernel::all_of(state.near),
                           kernel::pivot_at(state.near, static_cast<std::size_t>(j)), test,
                           state.flags, state.shared_indices);
  const int shared = static_cast<int>(state.shared_indices.size());
  if (shared + 2 < state.least_clique) return false;
  kernel::gather(state.near, state.shared_indices, state.shared);
  const int step = (shared + kMostTriedAsK - 1) / kMostTriedAsK;
  // Position and count of the best k, and of the next best.
  std::array<std::array<int, 2>, 2> best = {{{0, -1}, {0, -1}}};
  for (int k = 0; k < shared; k += step) {
    const auto pivot = kernel::pivot_at(state.shared, static_cast<std::size_t>(k));
    const int count = kernel::count_compatible(state.shared, pivot, test);
    if (count > best[1][1]) best[1] = {k, count};
    if (best[1][1] > best[0][1]) std::swap(best[0], best[1]);
  }
  const int size = best[0][1] + 3;
  if (size < state.least_clique) return false;
  for (const auto& [k, count] : best) {
    if (count + 3 < state.least_clique) break;
    take_clique(state, i, j, k, test);
    if (try_members(state)) return true;
    if (size > kSmallClique) break;
  }
  return false;
}

kernel::PairTest length_test(const SearchState& state, double scale, double spread) {
  const double tolerance = kLengthSigmas * state.sigma;
  kernel::PairTest test;
  test.scale = static_cast<float>(scale);
  test.tolerance2 = static_cast<float>(tolerance * tolerance);
  test.spread = static_cast<float>(spread);
  const double least = std::max(kLeastLength, kLeastLengthTolerances * tolerance);
  test.least_length2 = static_cast<float>(least * least);
  return test;
}

/// With j among them, unless that is negative.
void find_near(SearchState& state, int i, int j, const kernel::PairTest& test) {
  kernel::compatible_pairs(state.set.rows, state.window,
                           kernel::pivot_at(state.set.rows, static_cast<std::size_t>(i)), test,
                           state.flags, state.near_indices);
  ++state.visits;
  state.near_share +=
      (static_cast<double>(state.near_indices.size()) / static_cast<double>(state.window.size) -
       state.near_share) /
      state.visits;
  std::vector<int>& near = state.near_indices;
  if (near.size() > kMostNear) near.resize(kMostNear);  // what is left is a fair sample
  if (j >= 0 && !near.empty() && std::find(near.begin(), near.end(), j) == near.end()) {
    near.front() = j;
  }
  if (near.size() >= 2) kernel::gather(state.set.rows, near, state.near);
}

/// A visit of i where the scale is 1.
void visit(SearchState& state, int i, std::uint64_t counter) {
  const kernel::PairTest test = length_test(state, 1, 0);
  find_near(state, i, -1, test);
  const int near = static_cast<int>(state.near_indices.size());
  if (near < 2) return;
  if (state.set.n() <= kAllPairsBelow) {
    for (int j = 0; j < near; ++j) {
      if (state.near_indices[static_cast<std::size_t>(j)] > i) visit_partner(state, i, j, test);
    }
    return;
  }
  for (int draw = 0; draw < state.draws; ++draw) {
    const int j = drawn_below(counter * kDrawsOfJ + static_cast<std::uint64_t>(draw), near);
    if (visit_partner(state, i, j, test)) return;
  }
}

/// i and j say the scale; what keeps its distance from i by that scale is near.
void visit_with_scale_of(SearchState& state, int i, int j) {
  const auto at = [](int index) { return static_cast<std::size_t>(index); };
  const double length_a = (state.set.a[at(j)] - state.set.a[at(i)]).norm();
  const double length_b = (state.set.b[at(j)] - state.set.b[at(i)]).norm();
  if (!(length_a >= kLeastScaleLength && length_b >= kLeastScaleLength)) return;
  const double variance =
      1 / state.set.inverse_variance[at(i)] + 1 / state.set.inverse_variance[at(j)];
  const kernel::PairTest test =
      length_test(state, length_b / length_a, variance / (length_a * length_a));
  find_near(state, i, j, test);
  const auto here = std::find(state.near_indices.begin(), state.near_indices.end(), j);
  if (here == state.near_indices.end() || state.near_indices.size() < 2) return;
  visit_partner(state, i, static_cast<int>(here - state.near_indices.begin()), test);
}

void visit_with_scale(SearchState& state, int i, std::uint64_t counter) {
  const int n = static_cast<int>(state.set.rows.n);
  if (state.set.n() <= kAllPairsBelow) {
    for (int j = i + 1; j < n; ++j) visit_with_scale_of(state, i, j);
    return;
  }
  for (int draw = 0; draw < state.draws; ++draw) {
    const int j = drawn_below(counter * kDrawsOfJWithScale + static_cast<std::uint64_t>(draw), n);
    visit_with_scale_of(state, i, j);
  }
}

/// How many inliers the search reckons with: those of the best map, or the fewest that it seeks.
double reckoned_inliers(const SearchState& state) {
  const double n = static_cast<double>(state.set.rows.n);
  return std::clamp(state.best_score(), std::min(std::max(4.0, kLeastShare * n), n), n);
}

/// The share of inliers among what j is drawn from.
double share_of_partners(const SearchState& state) {
  const double n = static_cast<double>(state.set.rows.n);
  const double inliers = reckoned_inliers(state);
  const double near = state.set.estimates_scale ? n : std::max(state.near_share * n, inliers - 1);
  return std::min((inliers - 1) / near, 1.0);
}

/// Sets the window, the draws and the least size of a clique for the next visit.
void plan_visit(SearchState& state, std::uint64_t counter) {
  const std::size_t n = state.set.rows.n;
  const double inliers = reckoned_inliers(state);
  const double wanted = static_cast<double>(n) * kInliersInWindow / inliers;
  state.window = kernel::all_of(state.set.rows);
  if (wanted < static_cast<double>(n)) {
    const std::size_t lanes = kernel::kPairLanes;
    const std::size_t size =
        std::max(kLeastWindow, static_cast<std::size_t>(wanted) / lanes * lanes);
    if (size < n) {
      const int places = static_cast<int>((n - size) / lanes) + 1;
      state.window = {lanes * static_cast<std::size_t>(drawn_below(~counter, places)), size};
    }
  }
  const double near = state.near_share * static_cast<double>(state.window.size);
  const double expected = inliers * static_cast<double>(state.window.size) /
                          static_cast<double>(n) * std::min(1.0, kMostNear / near);
  state.least_clique = std::max(kLeastAgreeing, static_cast<int>(kWorthLooking * expected));
  if (state.set.n() <= kAllPairsBelow) state.least_clique = 3;
  const double share = share_of_partners(state);
  const int most = state.set.estimates_scale ? kDrawsOfJWithScale : kDrawsOfJ;
  state.draws = std::clamp(static_cast<int>(std::ceil(1.2 / share)), kLeastDrawsOfJ, most);
}

/// How many visits the stop rule asks for, with the best map so far.
double needed_visits(const SearchState& state) {
  const double share = reckoned_inliers(state) / static_cast<double>(state.set.rows.n);
  const double hit_of_draws = 1 - std::pow(1 - share_of_partners(state), state.draws);
  const double hit = kHitProbability * share * hit_of_draws;
  return std::max<double>(kLeastVisits, std::log(kMissProbability) / std::log1p(-hit));
}

}  // namespace

double consensus_radius(double sigma) {
  return kRadiusSigmas * sigma;
}

std::vector<Hypothesis> search_maps(const PairSet& set, double sigma) {
  SearchState state(set, sigma);
  const int n = static_cast<int>(state.set.rows.n);
  for (std::uint64_t counter = 0;; ++counter) {
    if (set.n() <= kAllPairsBelow && counter >= state.set.rows.n) break;
    if (set.n() > kAllPairsBelow && static_cast<double>(counter) >= needed_visits(state)) break;
    const int i = static_cast<int>(counter % static_cast<std::uint64_t>(n));
    plan_visit(state, counter);
    if (set.estimates_scale) {
      visit_with_scale(state, i, counter);
    } else {
      visit(state, i, counter);
    }
  }
  return state.best;
}

}  // namespace sightline::pair_consensus
