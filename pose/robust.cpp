// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/robust.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace sightline {
namespace {

std::uint64_t hash_of(const Eigen::Vector2d& pixel) {
  const std::uint64_t v = mixed_bits(std::bit_cast<std::uint64_t>(pixel.y()));
  return mixed_bits(std::bit_cast<std::uint64_t>(pixel.x()) + 0x9e3779b97f4a7c15u * v);
}

}  // namespace

std::optional<Eigen::Matrix2d> whitening_of(const Eigen::Matrix2d& covariance) {
  constexpr double kAsymmetry = 1e-9;
  if (!covariance.allFinite()) return std::nullopt;
  if (std::abs(covariance(0, 1) - covariance(1, 0)) > kAsymmetry * covariance.trace()) {
    return std::nullopt;
  }
  const Eigen::LLT<Eigen::Matrix2d> cholesky(covariance);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  const Eigen::Matrix2d whitening = cholesky.matrixL().solve(Eigen::Matrix2d::Identity());
  return whitening.allFinite() ? std::optional(whitening) : std::nullopt;
}

PreparedWhitened prepare_whitened(const PoseProblem& problem) {
  PreparedWhitened result;
  PreparedProblem prepared = prepare(problem);
  result.status = prepared.status;
  if (result.status != PoseStatus::kOk) return result;
  WhitenedCorrespondences& c = result.correspondences;
  c.points = std::move(prepared.correspondences);
  result.status = PoseStatus::kDegenerate;
  if (problem.covariances_px2.empty()) {
    if (!(problem.sigma_px >= 0) || !std::isfinite(problem.sigma_px)) return result;
    const bool is_known = problem.sigma_px > 0;
    c.sigma = is_known ? std::clamp(problem.sigma_px, kSmallestSigma, kLargestSigma) : 0;
    result.status = PoseStatus::kOk;
    return result;
  }
  if (problem.covariances_px2.size() != c.size()) return {PoseStatus::kTooFewPoints, {}};
  c.sigma = 1;
  const Eigen::Vector2d focal_px(c.points.fx_px, c.points.fy_px);
  for (std::size_t i = 0; i < c.size(); ++i) {
    const std::optional<Eigen::Matrix2d> whitening = whitening_of(problem.covariances_px2[i]);
    if (!whitening) return result;
    // A whitening of distorted pixels times the lens's derivative is one of undistorted pixels.
    const Eigen::Vector2d normalised = c.points.pixels[i].cwiseQuotient(focal_px);
    c.whitening.emplace_back(*whitening * lens_jacobian(problem.camera, normalised));
  }
  result.status = PoseStatus::kOk;
  return result;
}

std::optional<Eigen::Vector2d> whitened_residual(const WhitenedCorrespondences& c,
                                                 std::size_t index, const Pose& cam_from_centred) {
  std::optional<Eigen::Vector2d> r = residual_px(c.points, index, cam_from_centred);
  if (r && !c.whitening.empty()) *r = c.whitening[index] * *r;
  return r;
}

std::optional<Reprojection> whitened_reprojection(const WhitenedCorrespondences& c,
                                                  std::size_t index, const Pose& cam_from_centred) {
  std::optional<Reprojection> r = reproject(c.points, index, cam_from_centred);
  if (r && !c.whitening.empty()) {
    r->residual_px = c.whitening[index] * r->residual_px;
    r->jacobian = c.whitening[index] * r->jacobian;
  }
  return r;
}

std::vector<double> squared_residuals(const WhitenedCorrespondences& c,
                                      const Pose& cam_from_centred) {
  std::vector<double> squares(c.size());
  for (std::size_t i = 0; i < c.size(); ++i) {
    const std::optional<Eigen::Vector2d> r = whitened_residual(c, i, cam_from_centred);
    squares[i] = r ? r->squaredNorm() : std::numeric_limits<double>::infinity();
  }
  return squares;
}

PackedPoints packed(const WhitenedCorrespondences& c, std::span<const double> weights) {
  if (c.whitening.empty()) return PackedPoints(c.points, weights);
  std::vector<Eigen::Matrix2d> matrices;
  matrices.reserve(c.size());
  for (std::size_t i = 0; i < c.size(); ++i) {
    const double weight = weights.empty() ? 1.0 : weights[i];
    matrices.push_back(weight * c.whitening[i].transpose() * c.whitening[i]);
  }
  return PackedPoints(c.points, matrices);
}

LeastSquares whitened_least_squares(const WhitenedCorrespondences& c,
                                    std::span<const Pose> cam_from_centred_starts,
                                    const LspeOptions& options, std::span<const double> weights) {
  return least_squares(packed(c, weights), cam_from_centred_starts, options);
}

double tail_probability(double false_alarm_rate, std::size_t n) {
  const double rate = false_alarm_rate >= 1e-12 ? std::min(false_alarm_rate, 0.5) : 1e-12;
  return -std::expm1(std::log1p(-rate) / static_cast<double>(n));
}

double squared_threshold(double false_alarm_rate, std::size_t n) {
  return -2 * std::log(tail_probability(false_alarm_rate, n));
}

double sigma_from_median(std::span<const double> squared_residuals) {
  const std::size_t n = squared_residuals.size();
  if (n <= 3) return kSmallestSigma;
  std::vector<double> sorted(squared_residuals.begin(), squared_residuals.end());
  std::sort(sorted.begin(), sorted.end());
  const double median = 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
  const double left = static_cast<double>(n - 3) / static_cast<double>(n);
  const double sigma = std::sqrt(median / (2 * std::log(2.0) * left));
  return std::isfinite(sigma) ? std::max(sigma, kSmallestSigma) : kSmallestSigma;
}

std::uint64_t mixed_bits(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

std::vector<std::size_t> canonical_order(const Correspondences& c) {
  std::vector<std::size_t> order(c.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&c](std::size_t i, std::size_t j) {
    const std::uint64_t a = hash_of(c.pixels[i]), b = hash_of(c.pixels[j]);
    if (a != b) return a < b;
    return c.points_in_centred[i].squaredNorm() < c.points_in_centred[j].squaredNorm();
  });
  return order;
}

RobustFit fit_huber(const WhitenedCorrespondences& c, const Pose& start,
                    const LspeOptions& options) {
  constexpr int kMaxRounds = 30;
  constexpr double kSettled = 1e-3;           // change of sigma
  constexpr double kLeadingTolerance = 1e-4;  // steps while sigma is still settling
  if (c.sigma > 0) {
    return minimise_loss(c, start, HuberLoss{kHuberWidth * c.sigma},
                         kLimitFactor * options.max_iterations, options.step_tolerance);
  }
  const double no_limit = std::numeric_limits<double>::max();
  RobustFit fit = minimise_loss(c, start, HuberLoss{std::sqrt(no_limit)}, options.max_iterations,
                                kLeadingTolerance);
  int iterations = fit.iterations;
  if (fit.status == PoseStatus::kBehindCamera) return fit;
  double sigma = sigma_from_median(squared_residuals(c, fit.cam_from_centred));
  for (int round = 0; round < kMaxRounds && sigma > kSmallestSigma; ++round) {
    fit = minimise_loss(c, fit.cam_from_centred, HuberLoss{kHuberWidth * sigma},
                        options.max_iterations, kLeadingTolerance);
    iterations += fit.iterations;
    const double next = sigma_from_median(squared_residuals(c, fit.cam_from_centred));
    const bool is_settled = std::abs(next - sigma) <= kSettled * sigma;
    sigma = next;
    if (is_settled) break;
  }
  fit = minimise_loss(c, fit.cam_from_centred, HuberLoss{kHuberWidth * sigma},
                      kLimitFactor * options.max_iterations, options.step_tolerance);
  fit.sigma = sigma;
  fit.iterations += iterations;
  return fit;
}

Matrix6d weighted_information(const WhitenedCorrespondences& c, const Pose& cam_from_centred,
                              std::span<const double> weights) {
  return information_at(packed(c, weights), cam_from_centred).value_or(Matrix6d::Zero());
}

PoseEstimate estimate_of_failure(PoseStatus status) {
  PoseEstimate estimate;
  estimate.status = status;
  return estimate;
}

PoseEstimate estimate_from_fit(const RobustFit& fit, const WhitenedCorrespondences& c,
                               double smallest_kept_weight) {
  PoseEstimate estimate;
  estimate.status = fit.status;
  estimate.iterations = fit.iterations;
  if (estimate.status != PoseStatus::kOk) return estimate;
  const std::optional<Matrix6d> covariance =
      inverse_information(weighted_information(c, fit.cam_from_centred, fit.weights));
  if (!covariance) {
    estimate.status = PoseStatus::kDegenerate;
    return estimate;
  }
  for (std::size_t i = 0; i < fit.weights.size(); ++i) {
    if (fit.weights[i] < smallest_kept_weight) estimate.removed.push_back(static_cast<int>(i));
  }
  estimate.cam_from_target = from_centred(fit.cam_from_centred, c.points);
  estimate.unit_covariance = covariance_from_centred(*covariance, fit.cam_from_centred, c.points);
  return estimate;
}

PoseEstimate estimate_from_least_squares(const LeastSquares& solution, const Correspondences& c,
                                         std::vector<int> removed) {
  PoseEstimate estimate;
  estimate.status = solution.status;
  estimate.iterations = solution.iterations;
  if (estimate.status != PoseStatus::kOk) return estimate;
  estimate.removed = std::move(removed);
  estimate.cam_from_target = from_centred(solution.cam_from_centred, c);
  estimate.unit_covariance =
      covariance_from_centred(solution.unit_covariance, solution.cam_from_centred, c);
  return estimate;
}

}  // namespace sightline
