// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// ORPE by exact search: the fewest removals whose minimax residual passes for noise,
//
//   min |S|  subject to  M(S) = min over poses of max_{i not in S} f_i  <=  sigma^2 q(n - |S|),
//
// among sets of that size the one of least M(S), then the pose of least squares on what is left.
// q(m) is the quantile of the minimax residual of m points without outliers at OutlierOptions::
// false_alarm_rate (pose/minimax_null.h).
//
// The minimax of a set is that of its support, the points with positive multipliers: if the set
// fails, every smaller one that passes lacks a point of the support. So the children of a failed
// set are those without one point of its support each (K. Sim, R. Hartley: "Removing outliers using
// the L-infinity norm", CVPR 2006), and searching them by the number of removals, no set twice,
// finds the fewest (T.-J. Chin, P. Purkait, A. Eriksson, D. Suter: "Efficient globally optimal
// consensus maximisation with tree search", CVPR 2015).
//
// Needs four points that are not collinear, or three with an initial pose. Removes fewer than half
// of the points, or at most OutlierOptions::max_removed, and leaves at least two redundant
// coordinates, 2 (n - k) - 6 >= 2; tries at most kMaxSets sets. If none passes, the set of least
// M(S) / q is taken, and the diagnosis says is_removal_limit_reached and is_test_failed.
//
// Noise: from covariances_px2 if there are any, by which residuals and the final pose are whitened
// (carried through the lens; the quantiles are those of noise alike in all directions: with
// covariances of ratio 100 and 10 000 the false-alarm rate was 8 and 20 % instead of 1); else
// sigma_px; else the RMS residual per degree of freedom of what pose/solvers/orpe_calibrated.cpp
// keeps, which is too large when that overlooks an outlier, and then too little is removed here
// too. kTooFewPoints when covariances are neither none nor one a point, kDegenerate when one of
// them is not positive definite.
//
// Where it falls short: each M(S) is exact among poses near where it is sought from (the parent's
// pose; LSPE for the root), not over all poses. Of the two mirror starts of a plane each has a tree
// of its own; the two are searched side by side. (Against trying every set from the true pose: the
// same number of removals in 8000 of 8000 problems on six to eight vertices of a cube with outliers
// to 30 px, and in 99.8 % on as many points in a box, some of which have a mirror pose that no
// start shows; with two outliers of 1000 px in 57 of 60.)

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <set>

#include <Eigen/Cholesky>

#include "pose/fit_points.h"
#include "pose/minimax.h"
#include "pose/minimax_null.h"
#include "pose/removal_limits.h"
#include "pose/reprojection.h"
#include "pose/robust.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {
namespace {

constexpr std::size_t kMaxSets = 5000;
constexpr MinimaxOptions kSearch = {.relative_gap = 1e-7};
/// Multipliers of points off the maximum are below this at that gap.
constexpr double kSupportMultiplier = 1e-6;

/// Tests, and the support of, what is left without some points.
struct Node {
  std::vector<int> kept;
  Minimax fit;
  double excess = 0;  ///< M(S) / (sigma^2 q): at most one passes

  bool is_passed() const { return excess <= 1; }
};

class Search {
 public:
  Search(const Correspondences& c, std::span<const Eigen::Matrix2d> whitening, double sigma,
         double false_alarm_rate)
      : c_(c), whitening_(whitening), sigma_(sigma), false_alarm_rate_(false_alarm_rate) {}

  FitPoints points(const std::vector<int>& kept) const { return {c_, kept, whitening_}; }
  int iterations() const { return iterations_; }

  /// The node of a fit, or none where what is kept does not determine a pose.
  std::optional<Node> node(std::vector<int> kept, Minimax fit) {
    iterations_ += fit.iterations;
    if (fit.status != PoseStatus::kOk && fit.status != PoseStatus::kDiverged) return std::nullopt;
    Node node = {std::move(kept), std::move(fit), 0};
    const double allowed = sigma_ * sigma_ * minimax_quantile(node.kept.size(), false_alarm_rate_);
    node.excess = node.fit.largest_px2 / std::max(allowed, kZeroResidualPx2);
    // What is not proven to be the minimum is searched further rather than judged.
    if (node.fit.status == PoseStatus::kDiverged) node.excess = std::max(node.excess, 2.0);
    if (!unit_covariance(points(node.kept), node.fit.cam_from_centred)) return std::nullopt;
    return node;
  }

  /// The next level of the tree: the node of least excess of each set that was not tried before.
  std::vector<Node> children(const std::vector<Node>& level) {
    std::vector<Node> next;
    std::set<std::vector<int>> tried;
    for (const Node& parent : level) {
      for (std::size_t i = 0; i < parent.kept.size(); ++i) {
        const bool is_support = parent.fit.multipliers[i] > kSupportMultiplier ||
                                parent.fit.status == PoseStatus::kDiverged;
        if (!is_support || sets_ >= kMaxSets) continue;
        std::vector<int> kept = parent.kept;
        kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i));
        if (!tried.insert(kept).second) continue;
        ++sets_;
        Minimax fit = minimax_from(points(kept), parent.fit.cam_from_centred, kSearch);
        std::optional<Node> child = node(std::move(kept), std::move(fit));
        if (child) next.push_back(std::move(*child));
      }
    }
    return next;
  }

 private:
  const Correspondences& c_;
  std::span<const Eigen::Matrix2d> whitening_;
  double sigma_;
  double false_alarm_rate_;
  std::size_t sets_ = 0;
  int iterations_ = 0;
};

/// The root-mean-square residual per degree of freedom of what outward tests keep. Zero when they
/// fail or leave no freedom: then only exact data pass.
double noise_of_what_is_kept(const PoseProblem& problem, const Correspondences& c,
                             const SolverOptions& options) {
  const PoseEstimate estimate = solve_orpe_calibrated(problem, options);  // with sigma_px zero
  if (estimate.status != PoseStatus::kOk) return 0;
  const Pose pose = to_centred(estimate.cam_from_target, c);
  double sum_px2 = 0;
  for (std::size_t i = 0; i < c.size(); ++i) {
    if (std::ranges::count(estimate.removed, static_cast<int>(i))) continue;
    const std::optional<Eigen::Vector2d> r = residual_px(c, i, pose);
    if (r) sum_px2 += r->squaredNorm();
  }
  const double freedom = 2.0 * static_cast<double>(c.size() - estimate.removed.size()) - 6;
  return freedom > 0 ? std::sqrt(sum_px2 / freedom) : 0;
}

/// The nodes of both trees at one level, and the best of the level.
const Node* best_of(const std::vector<std::vector<Node>>& levels) {
  const Node* best = nullptr;
  for (const std::vector<Node>& level : levels) {
    for (const Node& node : level) {
      if (!best || node.excess < best->excess) best = &node;
    }
  }
  return best;
}

}  // namespace

PoseEstimate solve_orpe_tree(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate;
  const PreparedWhitened prepared = prepare_whitened(problem);
  estimate.status = prepared.status;
  if (estimate.status != PoseStatus::kOk) return estimate;
  const WhitenedCorrespondences& whitened = prepared.correspondences;
  const Correspondences& c = whitened.points;
  const std::size_t n = c.size();
  const double sigma =
      whitened.sigma > 0 ? whitened.sigma : noise_of_what_is_kept(problem, c, options);

  Search search(c, whitened.whitening, sigma, options.outliers.false_alarm_rate);
  std::vector<int> all(n);
  std::iota(all.begin(), all.end(), 0);
  std::vector<std::vector<Node>> levels;  // one a branch
  estimate.status = PoseStatus::kDegenerate;
  for (const Pose& start : starting_poses(c, problem.initial_cam_from_target)) {
    Minimax fit = minimax(search.points(all), {&start, 1}, options, kSearch);
    const bool is_fitted = fit.status == PoseStatus::kOk;
    if (levels.empty()) estimate.status = is_fitted ? PoseStatus::kDegenerate : fit.status;
    std::optional<Node> root = search.node(all, std::move(fit));
    if (root) levels.push_back({std::move(*root)});
  }
  if (levels.empty()) return estimate;

  Node best = *best_of(levels);
  const std::size_t limit = minority_limit(options.outliers, n);
  for (std::size_t removals = 0; !best.is_passed() && removals < limit; ++removals) {
    for (std::vector<Node>& level : levels) level = search.children(level);
    const Node* level_best = best_of(levels);
    if (!level_best) break;
    if (level_best->excess < best.excess) best = *level_best;
  }
  Diagnosis& diagnosis = estimate.diagnosis.emplace();
  diagnosis.is_test_failed = !best.is_passed();
  diagnosis.is_removal_limit_reached = !best.is_passed();
  estimate.iterations = search.iterations();
  std::set_difference(all.begin(), all.end(), best.kept.begin(), best.kept.end(),
                      std::back_inserter(estimate.removed));
  return with_least_squares(std::move(estimate), search.points(best.kept),
                            best.fit.cam_from_centred, options.lspe);
}

}  // namespace sightline
