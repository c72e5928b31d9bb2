// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/consensus/doubt.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace sightline::consensus {
namespace {

constexpr double kCertain = 0.9995;
constexpr double kImpossible = 1e-3;
/// Squared, in typical noises: what one in a thousand residuals exceeds of noise that is larger than
/// typical by as much as the prior doubts it.
const double kNoiseMayBe2 = 13.8 * std::exp(2 * kLargerNoiseDoubt);

/// The probability of a point to be an inlier of the pose that the others have: its residual
/// against the fit without it, and the variance of that (a Schur complement of 2 x 2).
double probability_without(const Cloud& cloud, const Mode& mode, const Matrix6d& covariance,
                           const Row& row, std::size_t i) {
  const Eigen::Map<const Eigen::Matrix<double, 2, 6, Eigen::RowMajor>> j(row.jacobian[0]);
  const Eigen::Map<const Eigen::Vector2d> r(row.residual);
  const double area = cloud.area(i);
  const Eigen::Matrix2d spread = j * covariance * j.transpose();
  const double w = mode.weights[i];
  const double weight = w / mode.variance + (1 - w) * mode.law.weight(row.squared(), area);
  const Eigen::Matrix2d rest = Eigen::Matrix2d::Identity() - weight * spread;
  constexpr double kDecidesAlone = 1e-9;
  if (!(rest.determinant() > kDecidesAlone)) return 0.5;
  const Eigen::Matrix2d inverse = rest.inverse();
  const Eigen::Vector2d residual = inverse * r;
  const Eigen::Matrix2d variance = inverse * spread + mode.variance * Eigen::Matrix2d::Identity();
  const double determinant = variance.determinant();
  if (!(determinant > 0)) return 0.5;
  const double log_inlier = std::log((1 - mode.outlier_share) / (2 * std::numbers::pi)) -
                            0.5 * std::log(determinant) -
                            0.5 * residual.dot(variance.inverse() * residual);
  const double log_outlier =
      std::log(mode.outlier_share * mode.law.density(residual.squaredNorm(), area));
  return 1 / (1 + std::exp(log_outlier - log_inlier));
}

/// Some points that agree closely by chance make a mode of small noise, to which the other inliers
/// are impossible: where the noise is not known, its size is one of the things to be weighed.
bool may_be_noise(const Cloud& cloud, double square) {
  return !cloud.is_sigma_known() &&
         square < kNoiseMayBe2 * cloud.typical_noise * cloud.typical_noise;
}

/// The inverse of what the mode's points say of the pose, each at its expected weight.
Matrix6d covariance_of(const Cloud& cloud, const Mode& mode, const LinearCloud& linear) {
  Quadratic sum;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!linear.is_seen[i]) continue;
    const double w = mode.weights[i];
    sum.add(linear.rows[i],
            w / mode.variance + (1 - w) * mode.law.weight(linear.squares[i], cloud.area(i)));
  }
  return sum.hessian.inverse();
}

}  // namespace

void Quadratic::add(const Row& row, double weight) {
  const Eigen::Map<const Vector6d> u(row.jacobian[0]), v(row.jacobian[1]);
  hessian.noalias() += weight * u * u.transpose();
  hessian.noalias() += weight * v * v.transpose();
  gradient.noalias() += weight * (u * row.residual[0] + v * row.residual[1]);
  squares += weight * row.squared();
}

void linearise(const Cloud& cloud, const Pose& cam_from_centred, LinearCloud& linear) {
  const std::size_t n = cloud.size();
  linear.cam_from_centred = cam_from_centred;
  linear.rows.resize(n);
  linear.squares.resize(n);
  linear.is_seen.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    linear.is_seen[i] = row_at(cloud, cam_from_centred, i, linear.rows[i]);
    linear.squares[i] = linear.is_seen[i] ? linear.rows[i].squared() : kernel::kNotSeen;
  }
}

Sorted sort_by_doubt(const Cloud& cloud, const Mode& mode, const LinearCloud& linear,
                     std::size_t most_doubtful) {
  const std::size_t n = cloud.size();
  const Matrix6d covariance = covariance_of(cloud, mode, linear);
  std::vector<double> without(n, 0);
  Sorted sorted;
  for (std::size_t i = 0; i < n; ++i) {
    if (!linear.is_seen[i]) {
      sorted.outliers.push_back(i);
      continue;
    }
    const double w = mode.weights[i];
    without[i] = probability_without(cloud, mode, covariance, linear.rows[i], i);
    const bool is_certain = w > kCertain && without[i] > kCertain;
    const bool is_outlier =
        w < kImpossible && without[i] < kImpossible && !may_be_noise(cloud, linear.squares[i]);
    const bool is_doubtful = n <= most_doubtful || !(is_certain || is_outlier);
    auto& side = is_doubtful ? sorted.doubtful : is_certain ? sorted.certain : sorted.outliers;
    side.push_back(i);
  }
  if (sorted.doubtful.size() <= most_doubtful) return sorted;
  sorted.is_exhaustive = false;
  std::ranges::stable_sort(sorted.doubtful, {}, [&](std::size_t i) {
    return std::abs(without[i] - 0.5) + std::abs(mode.weights[i] - 0.5);
  });
  for (std::size_t k = most_doubtful; k < sorted.doubtful.size(); ++k) {
    const std::size_t i = sorted.doubtful[k];
    (mode.weights[i] > 0.5 ? sorted.certain : sorted.outliers).push_back(i);
  }
  sorted.doubtful.resize(most_doubtful);
  return sorted;
}

}  // namespace sightline::consensus
