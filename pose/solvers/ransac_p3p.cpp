// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Random sample consensus over three-point poses:
//   1. Every triple of up to kMostEnumerated points, or drawn ones where there are more, gives up
//      to four poses (pose/p3p.h). Triples are drawn until one that is of inliers alone, and leads
//      to the consensus (every second one is said to), would have been met with a probability of
//      0.999, were the share of inliers that of the best consensus so far; at most kMostDraws.
//   2. A pose costs sum_i min(r_i^2, t^2); its consensus is the points with r_i <= t.
//   3. The kRefined cheapest are refined: least squares on the consensus, consensus again, until it
//      repeats itself. Where triples are drawn every record is refined at once, which makes the
//      consensus that says how many more are drawn.
//   4. The answer is least squares on the consensus of the best.
//
// Fischler and Bolles, "Random sample consensus", Communications of the ACM 24(6), 1981; the cost
// of step 2 is that of Torr and Zisserman (MSAC), CVIU 78(1), 2000, step 3 that of Chum, Matas and
// Kittler (LO-RANSAC), DAGM 2003.
//
// Needs four points that are not collinear, or three with an initial pose, which is one more
// candidate. t = sigma times the root of squared_threshold(false_alarm_rate). A consensus has at
// least n - max_removed points and never fewer than five: the nearest make up for missing ones, so
// that with up to five points this is least squares. Uses covariances_px2 (they whiten the
// residuals; sigma = 1), else sigma_px. Where sigma is not known, a pose costs the sum of its h =
// (n + 4) / 2 smallest r_i^2 and these are its consensus (least trimmed squares: Rousseeuw, JASA
// 79, 1984; Rousseeuw and Van Driessen, DMKD 12, 2006); sigma is then taken from that sum and, with
// the consensus of t, again until it settles. An estimated sigma has nu = 2 m - 6 degrees of
// freedom, m the points that it comes from, and t^2 is then the quantile of 2 F_{2, nu} in the
// place of chi2_2, in closed form nu (p^(-2 / nu) - 1) sigma^2.
//
// That only works for a share of outliers below a half; of known noise any share will do.
//
// Deviations: of few points no triple is left to chance. Drawn triples come from a stream with a
// fixed seed over an order of the points that does not depend on how they are given
// (canonical_order).

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "pose/p3p.h"
#include "pose/removal_limits.h"
#include "pose/robust.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {
namespace {

constexpr std::size_t kMostEnumerated = 18;  // 816 triples
constexpr std::size_t kMostDraws = 50000;
constexpr double kFewestDraws = 50;
constexpr double kMissed = 1e-3;
constexpr double kLeads = 0.5;
constexpr std::size_t kRefined = 8;
constexpr int kMaxRounds = 20;

/// What a consensus is and what a pose costs.
struct Rule {
  double t2 = 0;  ///< squared threshold, whitened; 0: only the `least` nearest points count
  std::size_t least = 0;
};

struct Candidate {
  Pose cam_from_centred;
  double cost = std::numeric_limits<double>::infinity();
};

/// The count-th smallest.
double order_statistic(std::vector<double> squares, std::size_t count) {
  const auto last = squares.begin() + static_cast<std::ptrdiff_t>(count - 1);
  std::ranges::nth_element(squares, last);
  return *last;
}

double cost_of(const std::vector<double>& squares, const Rule& rule) {
  if (rule.t2 > 0) {
    double cost = 0;
    for (const double r2 : squares) cost += std::min(r2, rule.t2);
    return cost;
  }
  std::vector<double> sorted = squares;
  const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(rule.least);
  std::ranges::nth_element(sorted, end - 1);
  return std::accumulate(sorted.begin(), end, 0.0);
}

/// Weight 1 for the points of the consensus, 0 for the others.
std::vector<double> consensus_of(const std::vector<double>& squares, const Rule& rule) {
  const double bound = std::max(rule.t2, order_statistic(squares, rule.least));
  std::vector<double> weights(squares.size());
  for (std::size_t i = 0; i < squares.size(); ++i) {
    weights[i] = squares[i] <= bound && std::isfinite(squares[i]) ? 1 : 0;
  }
  return weights;
}

struct Refined {
  LeastSquares solution;
  std::vector<double> weights;
  Candidate candidate;
};

/// Step 3. Of the rounds the one of least cost; status other than kOk when there is none.
Refined refine(const WhitenedCorrespondences& c, const Pose& start, const Rule& rule,
               const LspeOptions& options) {
  Refined best;
  std::vector<double> weights = consensus_of(squared_residuals(c, start), rule);
  Pose pose = start;
  int iterations = 0;
  for (int round = 0; round < kMaxRounds; ++round) {
    const LeastSquares solution = whitened_least_squares(c, std::span(&pose, 1), options, weights);
    iterations += solution.iterations;
    if (solution.status != PoseStatus::kOk) break;
    pose = solution.cam_from_centred;
    const std::vector<double> squares = squared_residuals(c, pose);
    const double cost = cost_of(squares, rule);
    if (cost < best.candidate.cost) best = {solution, weights, {pose, cost}};
    const std::vector<double> next = consensus_of(squares, rule);
    if (next == weights) break;
    weights = next;
  }
  best.solution.iterations = iterations;
  return best;
}

/// A stream of pseudo-random numbers with a fixed seed (SplitMix64).
class Stream {
 public:
  std::size_t below(std::size_t bound) {
    state_ += 0x9e3779b97f4a7c15u;
    return static_cast<std::size_t>(mixed_bits(state_) % bound);
  }

 private:
  std::uint64_t state_ = 1981;
};

using Triple = std::array<std::size_t, 3>;

P3pPoses poses_of(const Correspondences& c, const Triple& triple) {
  std::array<Eigen::Vector3d, 3> points, rays;
  for (std::size_t k = 0; k < 3; ++k) {
    points[k] = c.points_in_centred[triple[k]];
    rays[k] = {c.pixels[triple[k]].x() / c.fx_px, c.pixels[triple[k]].y() / c.fy_px, 1};
  }
  return p3p(points, rays);
}

/// Steps 1 and 2: the kRefined cheapest poses.
class Sampling {
 public:
  Sampling(const WhitenedCorrespondences& c, const Rule& rule, const LspeOptions& options)
      : c_(c), rule_(rule), options_(options), order_(canonical_order(c.points)) {}

  /// Cheapest first.
  std::vector<Candidate> run(const std::optional<Pose>& initial) {
    if (initial) consider(to_centred(*initial, c_.points));
    c_.size() <= kMostEnumerated ? enumerate() : draw();
    const auto end =
        candidates_.begin() + static_cast<std::ptrdiff_t>(std::min(kRefined, candidates_.size()));
    std::ranges::partial_sort(candidates_, end, {}, &Candidate::cost);
    candidates_.erase(end, candidates_.end());
    return std::move(candidates_);
  }

 private:
  void enumerate() {
    const std::size_t n = order_.size();
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        for (std::size_t k = j + 1; k < n; ++k) consider({order_[i], order_[j], order_[k]});
      }
    }
  }

  void draw() {
    const std::size_t n = order_.size();
    Stream stream;
    double record = std::numeric_limits<double>::infinity();
    double needed = kMostDraws;
    for (std::size_t draws = 0; draws < kMostDraws && static_cast<double>(draws) < needed;) {
      const Triple t = {stream.below(n), stream.below(n), stream.below(n)};
      if (t[0] == t[1] || t[0] == t[2] || t[1] == t[2]) continue;
      ++draws;
      consider({order_[t[0]], order_[t[1]], order_[t[2]]});
      keep_cheapest();
      if (candidates_.empty() || !(candidates_.front().cost < record)) continue;
      record = candidates_.front().cost;
      const Refined refined = refine(c_, candidates_.front().cam_from_centred, rule_, options_);
      if (!(refined.candidate.cost < record)) continue;
      record = refined.candidate.cost;
      candidates_.insert(candidates_.begin(), refined.candidate);
      needed = std::max(draws_needed(refined.weights), kFewestDraws);
    }
  }

  /// In order, as many as are refined at the end.
  void keep_cheapest() {
    std::ranges::stable_sort(candidates_, {}, &Candidate::cost);
    if (candidates_.size() > kRefined) candidates_.resize(kRefined);
  }

  static double draws_needed(const std::vector<double>& weights) {
    const double n = static_cast<double>(weights.size());
    const double m = std::accumulate(weights.begin(), weights.end(), 0.0);
    const double chance = kLeads * m * (m - 1) * (m - 2) / (n * (n - 1) * (n - 2));
    return std::log(kMissed) / std::log1p(-std::max(chance, 1e-12));
  }

  void consider(const Triple& triple) {
    const P3pPoses poses = poses_of(c_.points, triple);
    for (const Pose& pose : poses.all()) consider(pose);
  }

  void consider(const Pose& pose) {
    const double cost = cost_of(squared_residuals(c_, pose), rule_);
    if (std::isfinite(cost)) candidates_.push_back({pose, cost});
  }

  const WhitenedCorrespondences& c_;
  const Rule rule_;
  const LspeOptions& options_;
  const std::vector<std::size_t> order_;
  std::vector<Candidate> candidates_;
};

struct SampleSearch {
  Candidate best;  ///< of infinite cost when there is none
  int iterations = 0;
};

SampleSearch best_pose(const WhitenedCorrespondences& c, const std::optional<Pose>& initial,
                       const Rule& rule, const LspeOptions& options) {
  SampleSearch search;
  for (const Candidate& candidate : Sampling(c, rule, options).run(initial)) {
    const Refined refined = refine(c, candidate.cam_from_centred, rule, options);
    search.iterations += refined.solution.iterations;
    if (refined.candidate.cost < search.best.cost) search.best = refined.candidate;
  }
  return search;
}

/// sigma^2 from the sum of the h smallest of n squares: the mean of chi2_2 below its quantile h/n
/// is 2 - x (1 - h/n) / (h/n), x the quantile.
double trimmed_variance(double sum, std::size_t h, std::size_t n) {
  const double part = static_cast<double>(h) / static_cast<double>(n);
  const double mean = part < 1 ? 2 + 2 * std::log(1 - part) * (1 - part) / part : 2;
  return sum / static_cast<double>(2 * h - 6) * 2 / mean;
}

/// Step 4 where sigma is not known: sigma from the consensus and the consensus from sigma in turns.
Refined refine_with_sigma(const WhitenedCorrespondences& c, const Candidate& start,
                          std::size_t trimmed_to, std::size_t least_kept, double tail,
                          const LspeOptions& options) {
  constexpr double kSettled = 1e-6;
  constexpr double kSmallest = kSmallestSigma * kSmallestSigma;
  double variance = std::max(trimmed_variance(start.cost, trimmed_to, c.size()), kSmallest);
  double degrees = 2 * static_cast<double>(trimmed_to) - 6;
  Refined refined;
  Pose pose = start.cam_from_centred;
  int iterations = 0;
  for (int round = 0; round < kMaxRounds; ++round) {
    const double unit_t2 = degrees * (std::pow(tail, -2 / degrees) - 1);
    refined = refine(c, pose, {unit_t2 * variance, least_kept}, options);
    iterations += refined.solution.iterations;
    if (refined.solution.status != PoseStatus::kOk) break;
    pose = refined.candidate.cam_from_centred;
    degrees = 2 * std::accumulate(refined.weights.begin(), refined.weights.end(), 0.0) - 6;
    const double next = std::max(refined.solution.cost_px2 / degrees, kSmallest);
    const bool is_settled = std::abs(next - variance) <= kSettled * variance;
    variance = next;
    if (is_settled) break;
  }
  refined.solution.iterations = iterations;
  return refined;
}

std::vector<int> zeros_of(const std::vector<double>& weights) {
  std::vector<int> indices;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] == 0) indices.push_back(static_cast<int>(i));
  }
  return indices;
}

}  // namespace

PoseEstimate solve_ransac_p3p(const PoseProblem& problem, const SolverOptions& options) {
  const PreparedWhitened prepared = prepare_whitened(problem);
  if (prepared.status != PoseStatus::kOk) return estimate_of_failure(prepared.status);
  const WhitenedCorrespondences& c = prepared.correspondences;
  const std::optional<Pose>& initial = problem.initial_cam_from_target;
  const std::size_t n = c.size();
  const std::size_t least_kept = n - removal_limit(options.outliers, n);
  if (least_kept == n) {
    return estimate_from_least_squares(
        whitened_least_squares(c, starting_poses(c.points, initial), options.lspe), c.points, {});
  }
  if (initial &&
      !std::isfinite(std::ranges::max(squared_residuals(c, to_centred(*initial, c.points))))) {
    return estimate_of_failure(PoseStatus::kBehindCamera);
  }

  const double rate = options.outliers.false_alarm_rate;
  const std::size_t trimmed_to = std::max(least_kept, (n + 4) / 2);
  const bool is_sigma_known = c.sigma > 0;
  const Rule rule = is_sigma_known
                        ? Rule{squared_threshold(rate, n) * c.sigma * c.sigma, least_kept}
                        : Rule{0, trimmed_to};
  const SampleSearch search = best_pose(c, initial, rule, options.lspe);
  if (!std::isfinite(search.best.cost)) return estimate_of_failure(PoseStatus::kDegenerate);
  Refined refined = is_sigma_known ? refine(c, search.best.cam_from_centred, rule, options.lspe)
                                   : refine_with_sigma(c, search.best, trimmed_to, least_kept,
                                                       tail_probability(rate, n), options.lspe);
  refined.solution.iterations += search.iterations;
  return estimate_from_least_squares(refined.solution, c.points, zeros_of(refined.weights));
}

}  // namespace sightline
