// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "pose/absolute_orientation.h"
#include "pose/pose.h"

namespace sightline {

/// A pose between two clouds of matched points, and how far it may be trusted. The model is
/// x_b = scale R x_a + t + noise, the noise Gaussian and alike in the three coordinates, of
/// variance sigma_m^2 / w for a pair of weight w. Numbers are meaningful only with status kOk.
struct Alignment {
  OrientationStatus status = OrientationStatus::kTooFewPoints;
  Pose b_from_a;
  double scale = 1;
  /// The root of the weighted mean square of the residuals of the pairs that count: those with a
  /// weight and, from a method that removes pairs, not removed.
  double residual_rms_m = 0;
  /// |x_b - (scale R x_a + t)| of every pair, NaN where a coordinate is not finite.
  std::vector<double> residuals_m;
  /// The noise of one coordinate of a pair of weight 1: what was told, or what the residuals say.
  double sigma_m = 0;
  /// Covariance of (w, dt), b_from_a = (Exp(w) R, t + dt), radians and metres, for that noise.
  /// Where the noise was found from so many residuals it has the variance of Student's law, which
  /// is what is known of the error then. Infinite on the diagonal where nothing is left to find the
  /// noise from.
  Matrix6d covariance = Matrix6d::Zero();
  /// Standard deviation of the scale; 0 where it was not estimated.
  double scale_sd = 0;
};

/// What an OrientationEstimate lacks, at the cost of two more passes over the points. The status is
/// the estimate's, and nothing is computed unless that is kOk. The covariance is the estimator's
/// own to first order of the noise: that of least squares, with or without a scale, or that of the
/// affine way (OrientationMethod::fits).
///
/// `sigma_m`: standard deviation of a coordinate's noise (weight 1), or 0 to find it.
Alignment residuals_and_covariance(const OrientationEstimate& estimate, OrientationFit fit,
                                   std::span<const Eigen::Vector3d> points_in_a,
                                   std::span<const Eigen::Vector3d> points_in_b,
                                   std::span<const double> weights = {}, double sigma_m = 0);
Alignment residuals_and_covariance(const OrientationEstimate& estimate, OrientationFit fit,
                                   std::span<const Eigen::Vector3f> points_in_a,
                                   std::span<const Eigen::Vector3f> points_in_b,
                                   std::span<const double> weights = {}, double sigma_m = 0);

/// The two together: what a method of the catalogue finds, and how far it may be trusted.
template <typename Scalar>
Alignment align(const OrientationMethod& method,
                std::span<const Eigen::Matrix<Scalar, 3, 1>> points_in_a,
                std::span<const Eigen::Matrix<Scalar, 3, 1>> points_in_b,
                std::span<const double> weights = {}, double sigma_m = 0) {
  return residuals_and_covariance(method.estimate(points_in_a, points_in_b, weights), method.fits,
                                  points_in_a, points_in_b, weights, sigma_m);
}

}  // namespace sightline
