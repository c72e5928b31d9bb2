// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The evidence of a set of k inliers among n: a uniform prior of the share gives 1 / C(n, k), the
// map has the prior 1 / (V 8 pi^2) (and a scale that of a factor of 2 either way), and is
// integrated by Laplace's method, which is nearly exact as the residuals are nearly linear; unknown
// noise has the prior 1 / (sigma ln 1e6). So
//
//   ln E = -ln C(n, k) + k ln V - ln(V 8 pi^2) - 3k/2 ln 2 pi - 3/2 sum ln v + p/2 ln 2 pi
//          - 1/2 ln det H + { -(3k - p) ln sigma - Q / (2 sigma^2)
//                           { ln (Gamma(nu/2) / 2) - nu/2 ln(Q / 2) - ln ln 1e6,   nu = 3k - p
//
// with Q = sum r^2 / v and H the information of the p unknowns for noise of 1.

#include "pose/orientation/consensus_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>

namespace sightline::pair_consensus {
namespace {

/// Of more pairs one intruder does not change the noise by much.
constexpr std::size_t kMostSearchedForIntruders = 12;
/// The clouds, each in units of its own size, differ in scale by about a factor of 2.
const double kLogScaleDeviation = std::log(2.0);
/// So many agree at least that are held to be a set.
constexpr std::size_t kLeastInliers = 4;

double log_binomial(double n, double k) {
  return std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1);
}

}  // namespace

double log_evidence(const PairSet& set, std::span<const int> inliers, int n) {
  double log_variances = 0;
  for (const int i : inliers) {
    log_variances -= std::log(set.inverse_variance[static_cast<std::size_t>(i)]);
  }
  const double k = static_cast<double>(inliers.size());
  const double degrees = 3 * k - set.unknowns();
  const double nothing = -std::numeric_limits<double>::infinity();
  if (k < 3 || degrees < 1) return nothing;
  const std::optional<Similarity> map = fit_pairs(set, inliers);
  if (!map) return nothing;
  double squares = 0;
  for (const int i : inliers) {
    const auto at = static_cast<std::size_t>(i);
    squares += (*map * set.a[at] - set.b[at]).squaredNorm() * set.inverse_variance[at];
  }
  squares = std::max(squares, 3 * k * kLeastSigma * kLeastSigma);
  const Spread spread = spread_of(set, *map, inliers);
  const double trace = spread.about_mean.trace();
  const Eigen::Matrix3d turning = trace * Eigen::Matrix3d::Identity() - spread.about_mean;
  double log_det = 3 * std::log(spread.weight) + std::log(turning.determinant());
  if (set.estimates_scale) log_det += std::log(trace);
  const double log_two_pi = std::log(2 * std::numbers::pi);
  double log_prior = -std::log(set.volume * 8 * std::numbers::pi * std::numbers::pi);
  if (set.estimates_scale) {
    const double deviations = std::log(map->scale) / kLogScaleDeviation;
    log_prior -= 0.5 * deviations * deviations + std::log(kLogScaleDeviation) + 0.5 * log_two_pi;
  }
  double log_noise = 0;
  if (set.sigma > 0) {
    log_noise = -degrees * std::log(set.sigma) - squares / (2 * set.sigma * set.sigma);
  } else {
    log_noise = std::lgamma(degrees / 2) - std::log(2.0) - degrees / 2 * std::log(squares / 2) -
                std::log(std::log(1e6));
  }
  return -log_binomial(n, k) + k * std::log(set.volume) + log_prior - 1.5 * k * log_two_pi -
         1.5 * log_variances + 0.5 * set.unknowns() * log_two_pi - 0.5 * log_det + log_noise;
}

std::vector<int> probable_inliers(const Mixture& mixture) {
  std::vector<int> inliers;
  for (std::size_t i = 0; i < mixture.probability.size(); ++i) {
    if (mixture.probability[i] > 0.5) inliers.push_back(static_cast<int>(i));
  }
  return inliers;
}

std::vector<int> without_intruders(const PairSet& set, std::vector<int> inliers, int n) {
  if (inliers.size() > kMostSearchedForIntruders) return inliers;
  double evidence = log_evidence(set, inliers, n);
  while (inliers.size() > kLeastInliers) {
    std::vector<int> best;
    for (std::size_t left_out = 0; left_out < inliers.size(); ++left_out) {
      std::vector<int> fewer = inliers;
      fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(left_out));
      const double of_fewer = log_evidence(set, fewer, n);
      if (!(of_fewer > evidence)) continue;
      evidence = of_fewer;
      best = fewer;
    }
    if (best.empty()) break;
    inliers = best;
  }
  return inliers;
}

}  // namespace sightline::pair_consensus
