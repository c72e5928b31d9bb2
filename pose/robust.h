// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What the robust solvers share: residuals whitened by the covariances of the pixels, the scale of
// the noise, the threshold that separates noise from outliers, and M-estimation of a pose.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "pose/least_squares.h"
#include "pose/minimise.h"
#include "pose/packed_points.h"
#include "pose/reprojection.h"
#include "pose/solver.h"

namespace sightline {

/// Noise below this, stated or estimated, is rounding; noise above the other says nothing. (In
/// pixels, or in whitened units where there are covariances.)
inline constexpr double kSmallestSigma = 1e-6;
inline constexpr double kLargestSigma = 1e6;

/// A prepared problem whose residuals are whitened: W_i r_i has covariance sigma^2 I for an inlier.
/// With covariances C_i, W_i^T W_i = C_i^-1 (carried through the lens) and sigma = 1; without, W_i
/// = I and sigma = PoseProblem::sigma_px, taken into [kSmallestSigma, kLargestSigma] unless 0. A
/// solver's unit_covariance then is that for noise of the covariances given, or for unit noise
/// where there are none.
struct WhitenedCorrespondences {
  Correspondences points;
  std::vector<Eigen::Matrix2d> whitening;  ///< empty: identities
  double sigma = 0;                        ///< 0: not known

  std::size_t size() const { return points.size(); }
};

struct PreparedWhitened {
  PoseStatus status = PoseStatus::kDegenerate;  ///< kOk: the correspondences may be used
  WhitenedCorrespondences correspondences;
};

/// `prepare`, and the covariances. Beyond what `prepare` refuses: kTooFewPoints when there are
/// covariances but not one a point, kDegenerate when one is not positive definite or sigma_px is
/// negative or not finite.
PreparedWhitened prepare_whitened(const PoseProblem& problem);

/// W with W^T W = covariance^-1; none unless the covariance is symmetric and positive definite.
std::optional<Eigen::Matrix2d> whitening_of(const Eigen::Matrix2d& covariance);

/// The reprojection error of the point at `index`, alone or with its derivative (residual_px and
/// reproject of pose/reprojection.h), multiplied by the point's whitening.
std::optional<Eigen::Vector2d> whitened_residual(const WhitenedCorrespondences& c,
                                                 std::size_t index, const Pose& cam_from_centred);
std::optional<Reprojection> whitened_reprojection(const WhitenedCorrespondences& c,
                                                  std::size_t index, const Pose& cam_from_centred);

/// The squared whitened residual of every point; infinite for one that is not in front.
std::vector<double> squared_residuals(const WhitenedCorrespondences& c,
                                      const Pose& cam_from_centred);

/// The points packed for the kernel of least squares: the squared residual of each is
/// r^T W_i^T W_i r, times its weight where there are weights.
PackedPoints packed(const WhitenedCorrespondences& c, std::span<const double> weights = {});

/// least_squares on whitened residuals; cost_px2 is the sum of their weighted squares.
LeastSquares whitened_least_squares(const WhitenedCorrespondences& c,
                                    std::span<const Pose> cam_from_centred_starts,
                                    const LspeOptions& options,
                                    std::span<const double> weights = {});

/// The square t^2 of the residual, for sigma = 1, that none of n points of pure Gaussian noise
/// exceeds with probability 1 - false_alarm_rate: P(chi2_2 > t^2) = 1 - (1 - rate)^(1/n). The rate
/// is taken into [1e-12, 0.5].
double squared_threshold(double false_alarm_rate, std::size_t n);

/// The probability that the residual of one point of noise exceeds that threshold:
/// 1 - (1 - rate)^(1/n).
double tail_probability(double false_alarm_rate, std::size_t n);

/// sigma from the median of squared residuals of a fit of six parameters: that of chi2_2 is 2 ln 2,
/// and the fit takes six of the 2n degrees of freedom. At least kSmallestSigma.
double sigma_from_median(std::span<const double> squared_residuals);

/// A number in which every bit depends on every bit of `x`: the finaliser of SplitMix64 (Steele,
/// Lea, Flood, OOPSLA 2014).
std::uint64_t mixed_bits(std::uint64_t x);

/// An order of the points that depends neither on the order in which they are given nor on the
/// target's frame or unit: by a hash of their pixels. For solvers that draw from a fixed-seed
/// stream.
std::vector<std::size_t> canonical_order(const Correspondences& c);

/// Where losses have kinks or negative curvature Marquardt's method is slower than on squares: an
/// M-estimator may take this many times LspeOptions::max_iterations.
inline constexpr int kLimitFactor = 4;

/// What a robust loss says of a point, r^2 its squared residual: the cost rho(r), the weight
/// rho'(r) / r, and the curvature rho''(r).
struct Loss {
  double cost;
  double weight;
  double curvature;
};

/// Huber: least squares to `width`, absolute values beyond.
struct HuberLoss {
  double width;

  Loss operator()(double r2) const {
    if (r2 <= width * width) return {0.5 * r2, 1, 1};
    const double r = std::sqrt(r2);
    return {width * (r - 0.5 * width), width / r, 0};
  }
};

/// The width at which Huber's estimate of a mean of Gaussian vectors of the plane has 95 % of the
/// efficiency of least squares (1.345 is that of scalars), in units of sigma.
inline constexpr double kHuberWidth = 1.501;

/// One local fit of a robust solver.
struct RobustFit {
  PoseStatus status = PoseStatus::kDiverged;
  Pose cam_from_centred;
  double sigma = 0;             ///< known or estimated
  double cost = 0;              ///< of the solver's own loss
  std::vector<double> weights;  ///< rho'(r) / r at the pose
  int iterations = 0;
};

/// Minimises the sum of loss(r_i^2) over whitened residuals from one start by Marquardt's method on
///   gradient  sum w_i J_i^T r_i,
///   Hessian   sum w_i J_i^T J_i + (max(rho'', 0) - w_i) g_i g_i^T,   g_i = J_i^T r_i / |r_i|,
/// Newton's but for the second derivatives of the pixels and negative curvatures (Triggs et al.,
/// "Bundle adjustment - a modern synthesis", 2000, section 4.3). Every point must be in front.
/// kBehindCamera when the start has one behind; kDiverged when `max_iterations` did not do.
template <typename LossFunction>
RobustFit minimise_loss(const WhitenedCorrespondences& c, const Pose& start,
                        const LossFunction& loss, int max_iterations, double step_tolerance) {
  const auto evaluate = [&](const Pose& pose) -> std::optional<LocalModel> {
    LocalModel model;
    for (std::size_t i = 0; i < c.size(); ++i) {
      const std::optional<Reprojection> r = whitened_reprojection(c, i, pose);
      if (!r) return std::nullopt;
      const double r2 = r->residual_px.squaredNorm();
      const Loss value = loss(r2);
      model.cost += value.cost;
      if (value.weight == 0) continue;
      const Vector6d slope = r->jacobian.transpose() * r->residual_px;
      model.gradient += value.weight * slope;
      model.hessian.noalias() += value.weight * r->jacobian.transpose() * r->jacobian;
      const double excess = value.weight - std::max(value.curvature, 0.0);
      if (excess > 0 && r2 > 0)
        model.hessian.noalias() -= (excess / r2) * slope * slope.transpose();
    }
    return model;
  };
  const Minimum minimum = minimise(start, evaluate, max_iterations, step_tolerance);
  RobustFit fit;
  fit.status = minimum.status;
  fit.cam_from_centred = minimum.pose;
  fit.sigma = c.sigma;
  fit.cost = minimum.model.cost;
  fit.iterations = minimum.iterations;
  if (fit.status == PoseStatus::kBehindCamera) return fit;
  for (const double r2 : squared_residuals(c, fit.cam_from_centred)) {
    fit.weights.push_back(loss(r2).weight);
  }
  return fit;
}

/// Huber's estimate from one start. Where sigma is not known, minimising and estimating sigma from
/// the median residual take turns, from least squares, until sigma changes by less than a
/// thousandth.
RobustFit fit_huber(const WhitenedCorrespondences& c, const Pose& start,
                    const LspeOptions& options);

/// Runs `fit` (Pose -> RobustFit) from every start and keeps the best: success before failure, then
/// the smaller sigma where that is estimated, then the lower cost. iterations counts all.
template <typename Fit>
RobustFit best_fit(std::span<const Pose> starts, const Fit& fit) {
  RobustFit best;
  best.status = PoseStatus::kDegenerate;
  int iterations = 0;
  for (std::size_t k = 0; k < starts.size(); ++k) {
    RobustFit next = fit(starts[k]);
    iterations += next.iterations;
    const bool is_ok = next.status == PoseStatus::kOk;
    const bool was_ok = best.status == PoseStatus::kOk;
    const bool is_better = next.sigma != best.sigma ? next.sigma < best.sigma  //
                                                    : next.cost < best.cost;
    if (k == 0 || (is_ok && (!was_ok || is_better))) best = std::move(next);
  }
  best.iterations = iterations;
  return best;
}

/// The sum of weight_i J_i^T J_i over whitened Jacobians; zero where a point that has a weight is
/// behind the camera.
Matrix6d weighted_information(const WhitenedCorrespondences& c, const Pose& cam_from_centred,
                              std::span<const double> weights);

/// The estimate of a solver that has no pose; the status says why.
PoseEstimate estimate_of_failure(PoseStatus status);

/// The estimate of an M-estimator: the pose, the inverse of its weighted information, and as
/// removed the points of a weight below `smallest_kept_weight`. kDegenerate where the weights leave
/// a pose undetermined.
PoseEstimate estimate_from_fit(const RobustFit& fit, const WhitenedCorrespondences& c,
                               double smallest_kept_weight);

/// The estimate of least squares on some of the points; `removed` are the others, ascending.
PoseEstimate estimate_from_least_squares(const LeastSquares& solution, const Correspondences& c,
                                         std::vector<int> removed);

}  // namespace sightline
