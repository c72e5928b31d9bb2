// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// With x = s R (x_a - mean_a), S = sum w x x^T, W = sum w, w the weights and sigma^2 / w the
// noise's variance, the error of the pose is to first order
//
//   least squares   Cov(w) = sigma^2 (tr(S) I - S)^-1,
//   with a scale    the same, and Var(d ln s) = sigma^2 / tr(S), independent of it,
//   affine          w = 1/2 sum y_i x n_i, y_i = w_i S^-1 x_i, so that
//                   Cov(w) = sigma^2 (tr(S^-1) I - S^-1) / 4,
//
// and dt = mean error + (s R mean_a) x w - s R mean_a d ln s, with Var(mean error) = sigma^2 / W.
// What is expected of sum w |r|^2 is sigma^2 times 3 n - 6, 3 n - 7, or, for the affine way,
// 3 n - 9 + (tr(S) tr(S^-1) + 3) / 4, which is 3 n - 6 where S has no direction.

#include "pose/alignment.h"

#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace sightline {
namespace {

template <typename Scalar>
using Points = std::span<const Eigen::Matrix<Scalar, 3, 1>>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The weighted sums that the covariance needs, lengths in units of `unit_m`, so that no square
/// leaves the range of double.
struct Moments {
  double unit_m = 1;
  int count = 0;  ///< of the pairs with a weight
  double weight = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< of s R x_a, metres
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  double squares = 0;  ///< sum w |r|^2, units squared
};

double weight_at(std::span<const double> weights, std::size_t k) {
  return weights.empty() ? 1.0 : weights[k];
}

template <typename Scalar>
std::vector<double> residuals_of(const OrientationEstimate& estimate, Points<Scalar> in_a,
                                 Points<Scalar> in_b) {
  std::vector<double> residuals;
  for (std::size_t k = 0; k < in_a.size(); ++k) {
    const Eigen::Vector3d x =
        estimate.scale * (estimate.b_from_a.rotation * in_a[k].template cast<double>());
    const Eigen::Vector3d r = (x - in_b[k].template cast<double>()) + estimate.b_from_a.translation;
    residuals.push_back(r.allFinite() ? r.stableNorm() : std::numeric_limits<double>::quiet_NaN());
  }
  return residuals;
}

template <typename Scalar>
Moments moments_of(const OrientationEstimate& estimate, Points<Scalar> in_a,
                   std::span<const double> weights, const std::vector<double>& residuals) {
  Moments m;
  const auto turned = [&](std::size_t k) -> Eigen::Vector3d {
    return estimate.scale * (estimate.b_from_a.rotation * in_a[k].template cast<double>());
  };
  // About a point of the cloud that counts, which may lie far from the origin.
  std::size_t first = 0;
  while (weight_at(weights, first) == 0) ++first;
  const Eigen::Vector3d origin = turned(first);
  Eigen::Vector3d from_origin = Eigen::Vector3d::Zero();
  m.unit_m = 0;
  for (std::size_t k = 0; k < in_a.size(); ++k) {
    const double w = weight_at(weights, k);
    if (w == 0) continue;
    const Eigen::Vector3d x = turned(k) - origin;
    ++m.count;
    m.weight += w;
    from_origin += (w / m.weight) * (x - from_origin);
    m.unit_m = std::max(m.unit_m, x.cwiseAbs().maxCoeff());
  }
  if (!(m.unit_m > 0)) m.unit_m = 1;
  m.mean = origin + from_origin;
  for (std::size_t k = 0; k < in_a.size(); ++k) {
    const double w = weight_at(weights, k);
    if (w == 0) continue;
    const Eigen::Vector3d x = (turned(k) - origin - from_origin) / m.unit_m;
    const double r = residuals[k] / m.unit_m;
    m.spread.noalias() += (w * x) * x.transpose();
    m.squares += w * r * r;
  }
  return m;
}

double degrees_of_freedom(const Moments& m, OrientationFit fit) {
  switch (fit) {
    case OrientationFit::kRigid:
      return 3 * m.count - 6;
    case OrientationFit::kSimilarity:
      return 3 * m.count - 7;
    case OrientationFit::kAffine:
      return 3 * m.count - 9 + 0.25 * (m.spread.trace() * m.spread.inverse().trace() + 3);
  }
  return 0;
}

/// Of the rotation vector, for unit noise of weight 1 in units of length.
Eigen::Matrix3d rotation_covariance(const Moments& m, OrientationFit fit) {
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  if (fit == OrientationFit::kAffine) {
    const Eigen::Matrix3d inverse = m.spread.inverse();
    return 0.25 * (inverse.trace() * identity - inverse);
  }
  const Eigen::Matrix3d information = m.spread.trace() * identity - m.spread;
  return information.inverse();
}

/// For noise of `variance`, in units squared.
void set_covariance(const Moments& m, OrientationFit fit, double variance, double scale,
                    Alignment& alignment) {
  const Eigen::Vector3d q = m.mean / m.unit_m;
  Eigen::Matrix3d lever;
  lever << 0, -q.z(), q.y(), q.z(), 0, -q.x(), -q.y(), q.x(), 0;
  const Eigen::Matrix3d turning = variance * rotation_covariance(m, fit);
  Eigen::Matrix3d moving = lever * turning * lever.transpose();
  moving.diagonal().array() += variance / m.weight;
  if (fit == OrientationFit::kSimilarity) {
    const double log_scale = variance / m.spread.trace();
    moving += log_scale * q * q.transpose();
    alignment.scale_sd = scale * std::sqrt(log_scale);
  }
  Matrix6d& covariance = alignment.covariance;
  covariance.topLeftCorner<3, 3>() = turning;
  covariance.bottomLeftCorner<3, 3>() = m.unit_m * (lever * turning);
  covariance.topRightCorner<3, 3>() = covariance.bottomLeftCorner<3, 3>().transpose();
  covariance.bottomRightCorner<3, 3>() = m.unit_m * m.unit_m * moving;
  if (covariance.allFinite()) return;
  covariance = Vector6d::Constant(kInfinity).asDiagonal();
}

template <typename Scalar>
Alignment judge(const OrientationEstimate& estimate, OrientationFit fit, Points<Scalar> in_a,
                Points<Scalar> in_b, std::span<const double> weights, double sigma_m) {
  Alignment alignment;
  alignment.status = estimate.status;
  if (estimate.status != OrientationStatus::kOk) return alignment;
  alignment.b_from_a = estimate.b_from_a;
  alignment.scale = estimate.scale;
  alignment.residuals_m = residuals_of(estimate, in_a, in_b);
  const Moments m = moments_of(estimate, in_a, weights, alignment.residuals_m);
  alignment.residual_rms_m = m.unit_m * std::sqrt(m.squares / m.weight);
  const double degrees = degrees_of_freedom(m, fit);
  double variance = 0;
  if (sigma_m > 0) {
    alignment.sigma_m = sigma_m;
    variance = (sigma_m / m.unit_m) * (sigma_m / m.unit_m);
  } else if (degrees > 2) {
    alignment.sigma_m = m.unit_m * std::sqrt(m.squares / degrees);
    variance = m.squares / (degrees - 2);
  } else {
    alignment.sigma_m = degrees > 0 ? m.unit_m * std::sqrt(m.squares / degrees) : kInfinity;
    variance = kInfinity;
  }
  set_covariance(m, fit, variance, estimate.scale, alignment);
  return alignment;
}

}  // namespace

Alignment residuals_and_covariance(const OrientationEstimate& estimate, OrientationFit fit,
                                   std::span<const Eigen::Vector3d> points_in_a,
                                   std::span<const Eigen::Vector3d> points_in_b,
                                   std::span<const double> weights, double sigma_m) {
  return judge<double>(estimate, fit, points_in_a, points_in_b, weights, sigma_m);
}

Alignment residuals_and_covariance(const OrientationEstimate& estimate, OrientationFit fit,
                                   std::span<const Eigen::Vector3f> points_in_a,
                                   std::span<const Eigen::Vector3f> points_in_b,
                                   std::span<const double> weights, double sigma_m) {
  return judge<float>(estimate, fit, points_in_a, points_in_b, weights, sigma_m);
}

}  // namespace sightline
