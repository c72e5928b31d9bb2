// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/orientation/consensus_answer.h"

#include <cmath>
#include <limits>

namespace sightline::pair_consensus {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& x) {
  Eigen::Matrix3d m;
  m << 0, -x.z(), x.y(), x.z(), 0, -x.x(), -x.y(), x.x(), 0;
  return m;
}

/// Takes the covariance from the set's units to those that were given: t' = unit_b t + middle_b - s
/// R middle_a, so that dt' = unit_b dt + [q]x w - q d ln s with q = s R middle_a.
void set_covariance(const PairSet& set, const Mixture& mixture, Alignment& alignment) {
  const std::optional<Eigen::MatrixXd> covariance = covariance_of(set, mixture);
  if (!covariance) {
    alignment.covariance = Vector6d::Constant(kInfinity).asDiagonal();
    alignment.scale_sd = set.estimates_scale ? kInfinity : 0;
    return;
  }
  const Eigen::Vector3d q = alignment.scale * (alignment.b_from_a.rotation * set.middle_a);
  Eigen::MatrixXd given_from_set = Eigen::MatrixXd::Zero(6, set.unknowns());
  given_from_set.topLeftCorner<3, 3>().setIdentity();
  given_from_set.block<3, 3>(3, 0) = cross_matrix(q);
  given_from_set.block<3, 3>(3, 3).diagonal().setConstant(set.unit_b);
  if (set.estimates_scale) {
    given_from_set.block<3, 1>(3, 6) = -q;
    alignment.scale_sd = alignment.scale * std::sqrt((*covariance)(6, 6));
  }
  const Matrix6d given = given_from_set * *covariance * given_from_set.transpose();
  alignment.covariance = 0.5 * (given + given.transpose());
}

void set_residuals(const MatchedPoints& points, const PairSet& set, const Mixture& mixture,
                   RobustAlignment& alignment) {
  alignment.residuals_m.resize(points.in_a.size());
  double squares = 0;
  double weights = 0;
  for (std::size_t i = 0; i < set.a.size(); ++i) {
    const double residual = (mixture.map * set.a[i] - set.b[i]).norm();
    alignment.residuals_m[static_cast<std::size_t>(set.given_index[i])] = residual * set.unit_b;
    if (!(mixture.probability[i] > 0.5)) continue;
    squares += residual * residual * set.inverse_variance[i];
    weights += set.inverse_variance[i];
  }
  alignment.residual_rms_m = weights > 0 ? set.unit_b * std::sqrt(squares / weights) : 0;
  for (const int index : set.ignored) {
    const auto k = static_cast<std::size_t>(index);
    const Eigen::Vector3d x = alignment.scale * (alignment.b_from_a.rotation * points.in_a[k]) +
                              alignment.b_from_a.translation - points.in_b[k];
    alignment.residuals_m[k] = x.allFinite() ? x.norm() : std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace

RobustAlignment answer_of(const MatchedPoints& points, const PairSet& set, const Mixture& mixture) {
  RobustAlignment alignment;
  static_cast<Alignment&>(alignment) = in_given_units(set, mixture.map);
  alignment.ignored = set.ignored;
  alignment.sigma_m = mixture.sigma * set.sigma_unit_m;
  alignment.inlier_probabilities.assign(points.in_a.size(), 0);
  for (std::size_t i = 0; i < set.a.size(); ++i) {
    const int given = set.given_index[i];
    alignment.inlier_probabilities[static_cast<std::size_t>(given)] = mixture.probability[i];
  }
  std::size_t next_ignored = 0;
  for (std::size_t k = 0; k < points.in_a.size(); ++k) {
    const bool is_ignored =
        next_ignored < set.ignored.size() && set.ignored[next_ignored] == static_cast<int>(k);
    next_ignored += is_ignored;
    if (is_ignored || alignment.inlier_probabilities[k] > 0.5) continue;
    alignment.removed.push_back(static_cast<int>(k));
  }
  set_residuals(points, set, mixture, alignment);
  set_covariance(set, mixture, alignment);
  return alignment;
}

RobustAlignment failure(const PairSet& set, OrientationStatus status) {
  RobustAlignment failed;
  failed.status = status;
  failed.ignored = set.ignored;
  return failed;
}

std::optional<Mixture> certain_mixture(const PairSet& set, std::span<const int> inliers) {
  const std::optional<Similarity> map = fit_pairs(set, inliers);
  if (!map) return std::nullopt;
  Mixture mixture;
  mixture.map = *map;
  mixture.probability.assign(set.a.size(), 0);
  mixture.inliers = static_cast<double>(inliers.size());
  mixture.outlier_share = 1 - mixture.inliers / set.n();
  double squares = 0;
  for (const int index : inliers) {
    const auto k = static_cast<std::size_t>(index);
    mixture.probability[k] = 1;
    squares += (*map * set.a[k] - set.b[k]).squaredNorm() * set.inverse_variance[k];
  }
  const double degrees = std::max(3 * mixture.inliers - set.unknowns(), 1.0);
  mixture.sigma = set.sigma > 0 ? set.sigma : std::max(std::sqrt(squares / degrees), kLeastSigma);
  return mixture;
}

}  // namespace sightline::pair_consensus
