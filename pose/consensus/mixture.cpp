// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/consensus/mixture.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "pose/consensus/noise.h"

namespace sightline::consensus {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
/// Of the image's root area: how far a near outlier errs (20 pixels of 640 x 480).
constexpr double kNearScale = 0.036;
/// In near scales: where Student's tail no longer counts against the even density.
constexpr double kNearReach = 6;
/// The noise shrinks by no more than this in one iteration, so that points are not lost for good
/// while the pose is still far.
constexpr double kFastestShrinkKnown = 0.5;
constexpr double kFastestShrink = 0.4;
constexpr double kLeastInliers = 3.01;
constexpr double kLongestTurnRad = 0.5;
constexpr double kSmallestVariance = 1e-18;

/// What one pass over the points gives.
struct Sums {
  double hessian[21] = {};
  Vector6d gradient = Vector6d::Zero();
  double weight = 0;
  double weighted_squares = 0;
  double near = 0;  ///< outliers that are near ones

  void add(const Row& row, double factor) {
    double* next = hessian;
    for (int a = 0; a < 6; ++a) {
      const double u = factor * row.jacobian[0][a], v = factor * row.jacobian[1][a];
      gradient[a] += u * row.residual[0] + v * row.residual[1];
      for (int b = a; b < 6; ++b) *next++ += u * row.jacobian[0][b] + v * row.jacobian[1][b];
    }
  }

  Matrix6d matrix() const {
    Matrix6d m;
    const double* next = hessian;
    for (int a = 0; a < 6; ++a) {
      for (int b = a; b < 6; ++b) m(a, b) = m(b, a) = *next++;
    }
    return m;
  }
};

class MixtureFit {
 public:
  MixtureFit(const Cloud& cloud, double scale, const MixtureOptions& options, Mode& mode)
      : cloud_(cloud),
        options_(options),
        mode_(mode),
        widest_(std::max(kWidestNoise, cloud.sigma)) {
    if (!cloud.whitening.empty()) widest_ = std::max(scale, cloud.sigma);
    const double least = cloud.is_sigma_known() ? cloud.sigma : std::sqrt(kSmallestVariance);
    const double start = std::min(std::max(scale, least), widest_);
    mode.variance = start * start;
    mode.weights.assign(std::min(cloud.size(), options.points), 0);
  }

  bool run() {
    for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
      const Sums sums = accumulate();
      if (!(sums.weight >= kLeastInliers)) return false;
      const bool is_still = step(sums);
      if (is_failed_) return false;
      const bool is_settled = update_law(sums);
      const bool is_ripe = cloud_.is_sigma_known() || iteration >= 3;
      if (is_still && is_settled && is_ripe) break;
    }
    finish();
    return std::isfinite(mode_.log_likelihood);
  }

 private:
  /// Weighs the points and sums what Gauss and Newton ask for.
  Sums accumulate() {
    Sums sums;
    const double variance = mode_.variance, share = mode_.outlier_share;
    const double height = (1 - share) / (kTwoPi * variance);
    const double even = share * (1 - mode_.law.near_share);
    const double near_limit = kNearReach * kNearReach * mode_.law.scale2;
    for (std::size_t i = 0; i < mode_.weights.size(); ++i) {
      double& w = mode_.weights[i];
      w = 0;
      double r[2];
      if (!residual_at(cloud_, mode_.cam_from_centred, i, r)) continue;
      const double r2 = r[0] * r[0] + r[1] * r[1];
      const double area = cloud_.area(i);
      // A point whose odds are beyond 1e4 times too small does not count.
      if (r2 > cut(height * area / even) * variance) {
        if (r2 < near_limit * area) sums.near += mode_.law.near_probability(r2, area);
        continue;
      }
      const double inlier = height * std::exp(-0.5 * r2 / variance);
      w = inlier / (inlier + share * mode_.law.density(r2, area));
      sums.weight += w;
      sums.weighted_squares += w * r2;
      if (w < 0.99) sums.near += (1 - w) * mode_.law.near_probability(r2, area);
      Row row;
      if (!row_at(cloud_, mode_.cam_from_centred, i, row)) continue;
      sums.add(row, w + (1 - w) * mode_.law.weight(r2, area) * variance);
    }
    return sums;
  }

  /// The squared residual, in variances, beyond which a point of these odds does not count.
  double cut(double odds) {
    if (odds != cut_odds_) {
      cut_odds_ = odds;
      cut_ = 2 * std::log(std::max(10.0, 1e4 * odds));
    }
    return cut_;
  }

  /// Moves the pose; whether the step was shorter than the tolerance.
  bool step(const Sums& sums) {
    mode_.information = sums.matrix();
    Matrix6d damped = mode_.information;
    damped.diagonal() *= 1 + 1e-9;
    const Eigen::LLT<Matrix6d> cholesky(damped);
    Vector6d delta = -cholesky.solve(sums.gradient);
    double turn = delta.head<3>().norm();
    is_failed_ = cholesky.info() != Eigen::Success || !(turn < 1e3) || !delta.allFinite();
    if (is_failed_) return false;
    if (turn > kLongestTurnRad) delta *= kLongestTurnRad / turn;
    mode_.cam_from_centred = retract(mode_.cam_from_centred, delta);
    const double range = std::abs(mode_.cam_from_centred.translation.z());
    return turn < options_.step_tolerance &&
           delta.tail<3>().norm() < options_.step_tolerance * range;
  }

  /// Whether noise and shares hardly changed.
  bool update_law(const Sums& sums) {
    const double n = static_cast<double>(mode_.weights.size());
    const double scale = std::sqrt(mode_.variance);
    const double next = next_scale(sums, scale);
    const double outliers = n - sums.weight;
    const double share =
        std::clamp((outliers + kPriorOutliers) / (n + kPriorOutliers + kPriorInliers),
                   0.5 / (n + 1), 1 - 3 / (n + 1));
    const bool is_settled = std::abs(next - scale) < 1e-3 * scale + 1e-12 &&
                            std::abs(share - mode_.outlier_share) < 1e-2 * mode_.outlier_share;
    mode_.variance = next * next;
    mode_.outlier_share = share;
    mode_.inliers = sums.weight;
    mode_.law.near_share = std::clamp((sums.near + 0.3) / (outliers + 1.5), 0.02, 0.9);
    return is_settled;
  }

  double next_scale(const Sums& sums, double scale) const {
    if (cloud_.is_sigma_known()) return std::max(cloud_.sigma, kFastestShrinkKnown * scale);
    const double variance =
        noise_posterior(sums.weighted_squares, sums.weight - 3, cloud_.typical_noise).most_probable;
    const double next = std::sqrt(std::max(variance, kSmallestVariance));
    return std::min(std::max(next, kFastestShrink * scale), widest_);
  }

  /// The likelihood of all points that were looked at, at what was found.
  void finish() {
    constexpr double kNoInlier = 60;  // variances
    const double height = (1 - mode_.outlier_share) / (kTwoPi * mode_.variance);
    double log_likelihood = 0;
    for (std::size_t i = 0; i < mode_.weights.size(); ++i) {
      double r[2];
      const bool is_seen = residual_at(cloud_, mode_.cam_from_centred, i, r);
      const double r2 = is_seen ? r[0] * r[0] + r[1] * r[1] : kernel::kNotSeen;
      const double inlier =
          r2 < kNoInlier * mode_.variance ? height * std::exp(-0.5 * r2 / mode_.variance) : 0;
      log_likelihood +=
          std::log(inlier + mode_.outlier_share * mode_.law.density(r2, cloud_.area(i)));
    }
    mode_.log_likelihood = log_likelihood;
  }

  const Cloud& cloud_;
  const MixtureOptions& options_;
  Mode& mode_;
  double widest_;
  double cut_odds_ = 0;
  double cut_ = 0;
  bool is_failed_ = false;
};

}  // namespace

OutlierLaw outlier_law(const Cloud& cloud) {
  double noise2 = cloud.sigma * cloud.sigma;
  if (!cloud.areas.empty()) {
    std::vector<double> areas = cloud.areas;
    const auto middle = areas.begin() + static_cast<std::ptrdiff_t>(areas.size() / 2);
    std::nth_element(areas.begin(), middle, areas.end());
    noise2 = 1 / *middle;
  }
  OutlierLaw law;
  law.scale2 = std::max(kNearScale * kNearScale, 9 * noise2);
  return law;
}

bool fit_mixture(const Cloud& cloud, double scale, const MixtureOptions& options, Mode& mode) {
  return MixtureFit(cloud, scale, options, mode).run();
}

}  // namespace sightline::consensus
