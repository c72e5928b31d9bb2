// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// ORPE's minimax for many points and any share of outliers: a largest set of points whose minimax
// residual is that of pure noise, sought from the pose of consensus (pose/solvers/consensus.cpp).
// With t^2(k) the squared residual that none of k points of noise exceeds with a probability of 1 -
// false_alarm_rate (squared_threshold, pose/robust.h):
//
//   1. K = the points within t(n) of the pose of consensus.
//   2. Inward: while the exact minimax of K is above t^2(|K|), remove the point of the largest
//      multiplier.
//   3. Outward: the nearest point outside joins K if the minimax of K with it is at most
//      t^2(|K| + 1); no point is tried twice, and none beyond three times the bound.
//   4. The pose is that of least squares on K: the minimax decides who belongs to K, but as an
//      estimate it errs more than least squares the more points there are.
//
// The bound and the removal by the largest multiplier are those of Zhao, Zhang, Zuo, Xu (2009); the
// start and the outward step are ours.
//
// Needs what consensus needs, and leaves out the points that it leaves out. The noise is that of
// covariances_px2 (residuals are whitened), else sigma_px, else what consensus found. The
// covariance is that of least squares on K at that noise; the second pose and whether the answer is
// ambiguous or significant are those of consensus. Where fewer than four points are within the
// bound K is the set of consensus. With three points the answer is that of consensus.

#include <algorithm>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "pose/fit_points.h"
#include "pose/minimax.h"
#include "pose/robust.h"
#include "pose/solvers/solvers.h"

namespace sightline {
namespace {

constexpr std::size_t kFewestKept = kMinimumPosePoints;
/// In bounds, squared: how far a point may be that is still tried.
constexpr double kFarthestTried2 = 9;

/// The points of a problem that consensus could use, and where they stand in it.
struct UsablePart {
  PoseProblem problem;
  std::vector<int> given_index;
};

UsablePart without_ignored(const PoseProblem& problem, const std::vector<int>& ignored) {
  UsablePart part;
  part.problem.camera = problem.camera;
  part.problem.sigma_px = problem.sigma_px;
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    const int index = static_cast<int>(i);
    if (std::ranges::binary_search(ignored, index)) continue;
    part.given_index.push_back(index);
    part.problem.points_in_target.push_back(problem.points_in_target[i]);
    part.problem.pixels.push_back(problem.pixels[i]);
    if (problem.covariances_px2.empty()) continue;
    part.problem.covariances_px2.push_back(problem.covariances_px2[i]);
  }
  return part;
}

/// The search for the largest set.
class FeasibleSet {
 public:
  FeasibleSet(const WhitenedCorrespondences& c, double sigma, double false_alarm_rate)
      : c_(c), sigma2_(sigma * sigma), rate_(false_alarm_rate), is_kept_(c.size(), false) {}

  /// False where a minimax fails.
  bool find(const Pose& start, const std::vector<int>& consensus) {
    const std::vector<double> squares = squared_residuals(c_, start);
    for (std::size_t i = 0; i < c_.size(); ++i) {
      if (squares[i] <= bound(c_.size())) kept_.push_back(static_cast<int>(i));
    }
    if (kept_.size() < kFewestKept) kept_ = consensus;
    if (kept_.size() < kFewestKept) return false;
    best_ = minimax_of(kept_, start);
    while (best_.status == PoseStatus::kOk && kept_.size() > kFewestKept &&
           best_.largest_px2 > bound(kept_.size())) {
      kept_.erase(kept_.begin() + static_cast<std::ptrdiff_t>(best_.most_binding()));
      best_ = minimax_of(kept_, best_.cam_from_centred);
    }
    if (best_.status != PoseStatus::kOk) return false;
    grow();
    std::ranges::sort(kept_);
    return true;
  }

  const std::vector<int>& kept() const { return kept_; }
  const Minimax& minimax() const { return best_; }
  bool is_too_large() const { return best_.largest_px2 > bound(kept_.size()); }
  int iterations() const { return iterations_; }

 private:
  /// t^2(k).
  double bound(std::size_t k) const {
    return std::max(sigma2_ * squared_threshold(rate_, k), kZeroResidualPx2);
  }

  Minimax minimax_of(const std::vector<int>& kept, const Pose& start) {
    constexpr double kGap = 1e-4;
    const FitPoints points = {c_.points, kept, c_.whitening};
    Minimax result = minimax_from(points, start, {.relative_gap = kGap});
    iterations_ += result.iterations;
    return result;
  }

  void grow() {
    for (const int i : kept_) is_kept_[i] = true;
    std::vector<bool> is_done = is_kept_;
    for (;;) {
      const std::vector<double> squares = squared_residuals(c_, best_.cam_from_centred);
      int nearest = -1;
      double least = kFarthestTried2 * bound(kept_.size() + 1);
      for (std::size_t i = 0; i < c_.size(); ++i) {
        if (is_done[i] || !(squares[i] <= least)) continue;
        least = squares[i];
        nearest = static_cast<int>(i);
      }
      if (nearest < 0) return;
      is_done[nearest] = true;
      try_to_add(nearest, least);
    }
  }

  void try_to_add(int point, double square) {
    std::vector<int> more = kept_;
    more.push_back(point);
    if (square <= best_.largest_px2) {
      kept_ = std::move(more);
      best_.multipliers.push_back(0);
      return;
    }
    Minimax larger = minimax_of(more, best_.cam_from_centred);
    if (larger.status != PoseStatus::kOk || larger.largest_px2 > bound(more.size())) return;
    kept_ = std::move(more);
    best_ = std::move(larger);
  }

  const WhitenedCorrespondences& c_;
  const double sigma2_;
  const double rate_;
  std::vector<int> kept_;
  std::vector<bool> is_kept_;
  Minimax best_;
  int iterations_ = 0;
};

/// Of the points of a usable part, those that consensus kept.
std::vector<int> kept_by(const PoseEstimate& consensus, const UsablePart& part) {
  std::vector<int> kept;
  for (std::size_t i = 0; i < part.given_index.size(); ++i) {
    if (std::ranges::binary_search(consensus.removed, part.given_index[i])) continue;
    kept.push_back(static_cast<int>(i));
  }
  return kept;
}

}  // namespace

PoseEstimate solve_orpe_consensus(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate consensus = solve_consensus(problem, options);
  const UsablePart part = without_ignored(problem, consensus.ignored);
  if (consensus.status != PoseStatus::kOk || part.given_index.size() < kFewestKept) {
    return consensus;
  }
  const PreparedWhitened prepared = prepare_whitened(part.problem);
  const WhitenedCorrespondences& c = prepared.correspondences;
  PoseEstimate estimate = estimate_of_failure(prepared.status);
  estimate.ignored = consensus.ignored;
  if (prepared.status != PoseStatus::kOk) return estimate;

  const double sigma = c.sigma > 0 ? c.sigma : consensus.noise_px.value();
  FeasibleSet set(c, sigma, options.outliers.false_alarm_rate);
  const Pose start = to_centred(*consensus.diagnosis->most_probable_cam_from_target, c.points);
  if (!set.find(start, kept_by(consensus, part))) {
    estimate.status = PoseStatus::kDiverged;
    return estimate;
  }
  const FitPoints points = {c.points, set.kept(), c.whitening};
  estimate.iterations = consensus.iterations + set.iterations();
  estimate =
      with_least_squares(std::move(estimate), points, set.minimax().cam_from_centred, options.lspe);
  if (estimate.status != PoseStatus::kOk) return estimate;
  for (std::size_t i = 0; i < c.size(); ++i) {
    if (std::ranges::binary_search(set.kept(), static_cast<int>(i))) continue;
    estimate.removed.push_back(part.given_index[i]);
  }
  const std::optional<Matrix6d> covariance =
      unit_covariance(points, to_centred(estimate.cam_from_target, c.points));
  if (covariance) {
    estimate.covariance = covariance_from_centred(
        sigma * sigma * *covariance, to_centred(estimate.cam_from_target, c.points), c.points);
  }
  Diagnosis diagnosis;
  diagnosis.is_ambiguous = consensus.diagnosis->is_ambiguous;
  diagnosis.is_significant = consensus.diagnosis->is_significant;
  diagnosis.is_removal_limit_reached = set.kept().size() == kFewestKept && c.size() > kFewestKept;
  diagnosis.is_test_failed = set.is_too_large();
  estimate.diagnosis = diagnosis;
  estimate.noise_px = sigma;
  estimate.second_cam_from_target = consensus.second_cam_from_target;
  return estimate;
}

}  // namespace sightline
