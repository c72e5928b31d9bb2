// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// A pair is an inlier with probability 1 - e, its residual r then Gaussian of variance s^2 v in
// each coordinate, or an outlier, uniform in the volume V:
//
//   p_i = N_i / (N_i + e / V),   N_i = (1 - e) (2 pi s^2 v_i)^(-3/2) exp(-r_i^2 / (2 s^2 v_i)).
//
// The map is the weighted least squares of the p_i / v_i, in closed form. e = (n - sum p + 1) /
// (n + 5). s is the noise that is known, approached from above by halves; or s^2 = sum p r^2 / v /
// (3 sum p - unknowns), which falls to no less than 0.4 of the last in a round.

#include "pose/orientation/consensus_mixture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace sightline::pair_consensus {
namespace {

constexpr int kMostRounds = 60;
/// Converged when the map moves the cloud by less than this part of the noise.
constexpr double kMoveTolerance = 1e-4;
/// A pair counts for nothing where it is so much less probably an inlier than an outlier.
constexpr double kNegligible = 1e-6;

/// One round's numbers.
struct Weighing {
  double inliers = 0;
  double squares = 0;  ///< sum p r^2 / v
};

/// How far a change of the map moves the cloud.
double move_between(const Similarity& one, const Similarity& other) {
  return (one.scale * one.rotation - other.scale * other.rotation).norm() +
         (one.translation - other.translation).norm();
}

/// The odds of being an inlier of a pair of variance 1 that has no residual.
double odds_at_zero(const PairSet& set, const Mixture& mixture) {
  const double variance = mixture.sigma * mixture.sigma;
  return (1 - mixture.outlier_share) * set.volume /
         (mixture.outlier_share * std::pow(2 * std::numbers::pi * variance, 1.5));
}

/// What r^2 / v makes a pair negligible, whatever v is.
double negligible_square(const PairSet& set, const Mixture& mixture) {
  const double variance = mixture.sigma * mixture.sigma;
  const double ratio = odds_at_zero(set, mixture) / std::pow(set.least_variance, 1.5);
  return 2 * variance * std::log(std::max(ratio / kNegligible, 10.0));
}

/// Lists the pairs that are not negligible, with their probabilities.
Weighing weigh(const PairSet& set, const Mixture& mixture, std::span<const int> candidates,
               std::vector<int>& indices, std::vector<double>& probabilities) {
  const double half_precision = -0.5 / (mixture.sigma * mixture.sigma);
  const double at_zero = odds_at_zero(set, mixture);
  const double farthest = negligible_square(set, mixture);
  const bool has_weights = set.least_variance < 1;
  const Eigen::Matrix3d turn = mixture.map.scale * mixture.map.rotation;
  indices.clear();
  probabilities.clear();
  Weighing sums;
  for (const int index : candidates) {
    const auto k = static_cast<std::size_t>(index);
    const Eigen::Vector3d r = turn * set.a[k] + mixture.map.translation - set.b[k];
    const double r2 = r.squaredNorm() * set.inverse_variance[k];
    if (!(r2 < farthest)) continue;
    double odds = at_zero * std::exp(half_precision * r2);
    if (has_weights) odds *= std::pow(set.inverse_variance[k], 1.5);
    if (!(odds > kNegligible)) continue;
    const double p = odds / (1 + odds);
    indices.push_back(index);
    probabilities.push_back(p);
    sums.inliers += p;
    sums.squares += p * r2;
  }
  return sums;
}

/// The pairs that may come to count while the map moves a little and the noise shrinks: those at
/// less than twice the distance at which they count.
struct Candidates {
  std::vector<int> indices;
  Similarity listed_at;
  double listed_sigma = 0;
  double slack = 0;  ///< how far the map may move the cloud

  void list(const PairSet& set, const Mixture& mixture, int n) {
    const double square = negligible_square(set, mixture);
    indices.clear();
    for (int i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double r2 = (mixture.map * set.a[k] - set.b[k]).squaredNorm();
      if (r2 * set.inverse_variance[k] < 4 * square) indices.push_back(i);
    }
    listed_at = mixture.map;
    listed_sigma = mixture.sigma;
    slack = std::sqrt(square * set.least_variance);
  }
  bool are_valid_for(const Mixture& mixture) const {
    return mixture.sigma <= listed_sigma && move_between(mixture.map, listed_at) < slack;
  }
};

double next_sigma(const PairSet& set, const Weighing& sums, double sigma) {
  if (set.sigma > 0) return std::max(set.sigma, 0.5 * sigma);
  const double degrees = std::max(3 * sums.inliers - set.unknowns(), 1.0);
  const double found = std::sqrt(sums.squares / degrees);
  return std::clamp(found, std::max(0.4 * sigma, kLeastSigma), set.largest_sigma());
}

}  // namespace

std::optional<Mixture> fit_mixture(const PairSet& set, const Similarity& start, double start_sigma,
                                   int n) {
  Mixture mixture;
  mixture.map = start;
  mixture.sigma = std::max(start_sigma, kLeastSigma);
  Candidates candidates;
  std::vector<int> indices;
  std::vector<double> probabilities;
  for (int round = 0; round < kMostRounds; ++round) {
    if (!candidates.are_valid_for(mixture)) candidates.list(set, mixture, n);
    const Weighing sums = weigh(set, mixture, candidates.indices, indices, probabilities);
    if (sums.inliers < 3.01) return std::nullopt;
    const std::optional<Similarity> map = fit_pairs(set, indices, probabilities);
    if (!map) return std::nullopt;
    const double sigma = next_sigma(set, sums, mixture.sigma);
    const double share =
        std::clamp((n - sums.inliers + 1) / (n + 5.0), 0.5 / (n + 1.0), 1 - 3.0 / (n + 1.0));
    const bool is_done = move_between(*map, mixture.map) < kMoveTolerance * sigma &&
                         std::abs(sigma - mixture.sigma) < kMoveTolerance * sigma;
    mixture.map = *map;
    mixture.sigma = sigma;
    mixture.outlier_share = share;
    mixture.inliers = sums.inliers;
    if (is_done) break;
  }
  mixture.probability.assign(static_cast<std::size_t>(n), 0);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    mixture.probability[static_cast<std::size_t>(indices[i])] = probabilities[i];
  }
  return mixture;
}

std::optional<Eigen::MatrixXd> covariance_of(const PairSet& set, const Mixture& mixture) {
  const int unknowns = set.unknowns();
  const double variance = mixture.sigma * mixture.sigma;
  Eigen::MatrixXd certain = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::MatrixXd doubt = certain;
  Eigen::Matrix<double, 3, Eigen::Dynamic> jacobian(3, unknowns);
  for (std::size_t i = 0; i < mixture.probability.size(); ++i) {
    const double p = mixture.probability[i];
    if (p == 0) continue;
    const Eigen::Vector3d q = mixture.map.scale * (mixture.map.rotation * set.a[i]);
    jacobian.leftCols<3>() << 0, q.z(), -q.y(), -q.z(), 0, q.x(), q.y(), -q.x(), 0;
    jacobian.middleCols<3>(3).setIdentity();
    if (unknowns == 7) jacobian.col(6) = q;
    const double information = set.inverse_variance[i] / variance;
    const Eigen::Vector3d r = q + mixture.map.translation - set.b[i];
    const Eigen::VectorXd slope = information * (jacobian.transpose() * r);
    certain.noalias() += (p * information) * jacobian.transpose() * jacobian;
    doubt.noalias() += (p * (1 - p)) * slope * slope.transpose();
  }
  Eigen::LLT<Eigen::MatrixXd> factor(certain - doubt);
  if (factor.info() != Eigen::Success) factor.compute(certain);
  if (factor.info() != Eigen::Success) return std::nullopt;
  Eigen::MatrixXd covariance = factor.solve(Eigen::MatrixXd::Identity(unknowns, unknowns));
  const double degrees = 3 * mixture.inliers - unknowns;
  if (set.sigma <= 0 && !(degrees > 2)) return std::nullopt;
  if (set.sigma <= 0) covariance *= degrees / (degrees - 2);
  if (!covariance.allFinite()) return std::nullopt;
  return covariance;
}

}  // namespace sightline::pair_consensus
