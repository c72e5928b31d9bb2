// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The iteration; the algebra of one step of it is in pose/interior_point.h. It solves
// min t subject to f_i(x) + s_i = t, s_i >= 0, over poses x, f_i = |r_i|^2, by a primal-dual
// interior point method with Mehrotra's predictor and corrector (S. Wright: Primal-dual
// interior-point methods, 1997, chapter 10; for problems of this kind C. Olsson, A. Eriksson,
// F. Kahl: "Efficient optimization for L-infinity problems using pseudoconvexity", ICCV 2007).
//
// The corrector takes into account ds_i dl_i, as Mehrotra's does, and |J_i dx|^2, the second order
// of f_i where the residual is linear in the pose. Seven iterations reach a gap of 1e-9.
//
// There is no line search. Where the iteration wanders (one problem in ten thousand, where the
// active constraints leave a direction almost free) it is begun again from the lowest maximum that
// it passed.

#include "pose/minimax.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "pose/interior_point.h"

namespace sightline {
namespace {

using interior_point::Constraint;
using interior_point::NewtonSystem;
using interior_point::Step;
using interior_point::StepLengths;

/// The iteration from one start. It may be run from several in turn and keeps its storage.
class InteriorPoint {
 public:
  InteriorPoint(const FitPoints& points, const MinimaxOptions& options)
      : points_(points), options_(options), constraints_(points.size()) {}

  /// Where the maximum was lowest so far.
  const Pose& lowest() const { return lowest_; }

  /// Iterates until the gap is closed or the limit is reached. Second derivatives of the residuals
  /// are left out in the first `gauss_newton_iterations`.
  Minimax run(const Pose& start, int gauss_newton_iterations, int max_iterations) {
    Minimax result;
    result.cam_from_centred = start;
    result.multipliers.assign(constraints_.size(), 1 / static_cast<double>(constraints_.size()));
    lowest_ = start;
    if (!evaluate(points_, start, options_.free, constraints_)) {
      result.status = PoseStatus::kBehindCamera;
      return result;
    }
    lowest_px2_ = largest_of(constraints_);
    if (lowest_px2_ < kZeroResidualPx2) return exact(std::move(result));

    centre();
    while (result.iterations < max_iterations) {
      ++result.iterations;
      const bool is_exact = result.iterations > gauss_newton_iterations;
      if (!step(result.cam_from_centred, is_exact)) break;
      const double largest_px2 = largest_of(constraints_);
      if (largest_px2 < kZeroResidualPx2) return exact(std::move(result));
      if (largest_px2 < lowest_px2_) {
        lowest_px2_ = largest_px2;
        lowest_ = result.cam_from_centred;
      }
      const double products = mean_product(constraints_) * static_cast<double>(points_.size());
      if (products > options_.relative_gap * largest_px2) continue;
      const double gap = relative_gap(constraints_);
      if (gap > options_.relative_gap) continue;
      result.relative_gap = gap;
      break;
    }
    return finished(std::move(result));
  }

 private:
  /// Slacks and multipliers of equal products at a pose; the multipliers sum to one.
  void centre() {
    constexpr double kInitialSlack = 0.3;  // of the largest residual
    t_ = (1 + kInitialSlack) * largest_of(constraints_);
    double inverse_sum = 0;
    for (Constraint& c : constraints_) {
      c.slack = t_ - c.f;
      inverse_sum += 1 / c.slack;
    }
    for (Constraint& c : constraints_) c.multiplier = 1 / (c.slack * inverse_sum);
  }

  /// The longest step, in radians or as a part of the range: beyond it the model means nothing.
  static constexpr double kLongestTurn = 0.3;

  /// One predictor and corrector, with the second derivatives of the residuals if `is_exact`. False
  /// where there is no step, or where it leads behind the camera.
  bool step(Pose& pose, bool is_exact) {
    constexpr double kSmallestMu = 1e-3;  // of what the gap allows
    constexpr double kLargestRidge = 0.05;
    const Matrix6d curvature = is_exact
                                   ? residual_curvature(points_, pose, options_.free, constraints_)
                                   : Matrix6d::Zero();
    std::optional<NewtonSystem> system = newton_system(constraints_, curvature, 0);
    if (!system) return false;
    for (Constraint& c : constraints_) {
      c.miss = c.f + c.slack - t_;
      c.correction = 0;
    }
    const double products = mean_product(constraints_);
    const double smallest_mu = kSmallestMu * options_.relative_gap * largest_of(constraints_) /
                               static_cast<double>(points_.size());
    Step predictor = newton_step(*system, constraints_, 0);
    while (is_exact && system->ridge < kLargestRidge && length(predictor, pose) > kLongestTurn) {
      system = newton_system(constraints_, curvature, 5 * system->ridge);
      if (!system) return false;
      predictor = newton_step(*system, constraints_, 0);
    }
    const double mu = std::max(predict(constraints_, predictor, products), smallest_mu);
    return advance(pose, newton_step(*system, constraints_, mu));
  }

  /// Takes as much of a step as keeps slacks and multipliers positive, the turn short and the
  /// points in front of the camera. False, and the pose stays, where no part of it does.
  bool advance(Pose& pose, const Step& corrected) {
    constexpr double kTowardsBoundary = 0.99;
    constexpr int kMostHalvings = 8;
    StepLengths lengths = longest_steps(constraints_, kTowardsBoundary);
    const double turn = length(corrected, pose);
    if (lengths.primal * turn > kLongestTurn) lengths.primal = kLongestTurn / turn;
    Pose candidate = retract(pose, lengths.primal * corrected.delta);
    int halvings = 0;
    while (!evaluate(points_, candidate, options_.free, constraints_)) {
      if (++halvings > kMostHalvings) {
        evaluate(points_, pose, options_.free, constraints_);
        return false;
      }
      lengths.primal *= 0.5;
      candidate = retract(pose, lengths.primal * corrected.delta);
    }
    pose = candidate;
    t_ += lengths.primal * corrected.bound_change;
    for (Constraint& c : constraints_) {
      // A slack may grow to what there is: the constraint is then met.
      c.slack = std::max(c.slack + lengths.primal * c.slack_change, t_ - c.f);
      c.multiplier += lengths.dual * c.multiplier_change;
    }
    return true;
  }

  /// The result where all residuals are zero.
  static Minimax exact(Minimax result) {
    result.status = PoseStatus::kOk;
    result.largest_px2 = 0;
    result.relative_gap = 0;
    return result;
  }

  /// The result with its multipliers, its maximum and, by the gap, its status.
  Minimax finished(Minimax result) const {
    double sum = 0;
    for (const Constraint& c : constraints_) sum += c.multiplier;
    for (std::size_t i = 0; i < constraints_.size(); ++i) {
      result.multipliers[i] = constraints_[i].multiplier / sum;
    }
    result.largest_px2 = largest_of(constraints_);
    const double promised = std::max(kMinimaxGap, options_.relative_gap);
    if (!(result.relative_gap <= promised)) result.relative_gap = relative_gap(constraints_);
    if (result.relative_gap <= promised) result.status = PoseStatus::kOk;
    return result;
  }

  FitPoints points_;
  MinimaxOptions options_;
  std::vector<Constraint> constraints_;
  double t_ = 0;
  double lowest_px2_ = 0;
  Pose lowest_;
};

}  // namespace

std::size_t Minimax::most_binding() const {
  return static_cast<std::size_t>(std::max_element(multipliers.begin(), multipliers.end()) -
                                  multipliers.begin());
}

Minimax minimax_from(const FitPoints& points, const Pose& cam_from_centred_start,
                     const MinimaxOptions& options) {
  // Second derivatives cost a quarter more a step, and only one problem in a hundred needs them.
  constexpr int kGaussNewtonIterations = 8;
  constexpr std::array<int, 4> kAttempts = {30, 60, 60, 60};

  InteriorPoint iteration(points, options);
  Pose start = cam_from_centred_start;
  Minimax result;
  int iterations = 0;
  for (const int max_iterations : kAttempts) {
    result = iteration.run(start, iterations == 0 ? kGaussNewtonIterations : 0, max_iterations);
    iterations += result.iterations;
    if (result.status != PoseStatus::kDiverged) break;
    start = iteration.lowest();
  }
  result.iterations = iterations;
  return result;
}

Minimax minimax(const FitPoints& points, std::span<const Pose> cam_from_centred_starts,
                const SolverOptions& options, const MinimaxOptions& minimax_options) {
  Minimax best;
  best.status = PoseStatus::kDegenerate;
  int iterations = 0;
  for (const Pose& start : cam_from_centred_starts) {
    const LeastSquares begin = least_squares(points, {&start, 1}, options.lspe);
    iterations += begin.iterations;
    Minimax fit;
    fit.status = begin.status;
    // Where least squares stopped is a start as good as another.
    if (begin.status == PoseStatus::kOk || begin.status == PoseStatus::kDiverged) {
      fit = minimax_from(points, begin.cam_from_centred, minimax_options);
    }
    iterations += fit.iterations;
    const bool is_first = &start == cam_from_centred_starts.data();
    const bool is_ok = fit.status == PoseStatus::kOk;
    const bool was_ok = best.status == PoseStatus::kOk;
    if (is_first || (is_ok && (!was_ok || fit.largest_px2 < best.largest_px2))) {
      best = std::move(fit);
    }
  }
  best.iterations = iterations;
  return best;
}

}  // namespace sightline
