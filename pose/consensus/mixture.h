// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The law by which residuals are weighed: inliers of one size of noise among outliers that are
// anywhere in the image or near the truth; and the pose of greatest likelihood near a start.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

#include "pose/consensus/cloud.h"

namespace sightline::consensus {

/// The density of an outlier's residual r: near the truth by Student's law of two degrees of
/// freedom, or evenly over the image, whose area is 1. With covariances, in the units of each
/// point's noise, `area` being that of the image in them.
struct OutlierLaw {
  double scale2 = 1;  ///< squared scale of the near ones
  double near_share = 0.2;

  double near_density(double r2) const {
    const double k = 1 + r2 / (2 * scale2);
    return near_share / (2 * std::numbers::pi * scale2 * k * k);
  }
  double density(double r2, double area) const {
    return (near_density(r2 / area) + 1 - near_share) / area;
  }
  /// The probability that an outlier with this residual is one of the near ones.
  double near_probability(double r2, double area) const {
    const double near = near_density(r2 / area);
    return near / (near + 1 - near_share);
  }
  /// The weight of an outlier in least squares: -(d ln density / dr) / r.
  double weight(double r2, double area) const {
    const double k = 1 + r2 / (area * 2 * scale2);
    return near_probability(r2, area) * 2 / (scale2 * area * k);
  }
};

/// The law of a cloud's outliers before anything is known of their errors.
OutlierLaw outlier_law(const Cloud& cloud);

/// A pose that explains some of the points, and how.
struct Mode {
  Pose cam_from_centred;
  double variance = 1;  ///< of an inlier's residual, each coordinate
  double outlier_share = 0.3;
  OutlierLaw law;
  std::vector<double> weights;  ///< the probability of each point to be an inlier
  double inliers = 0;           ///< sum of the weights
  double log_likelihood = -std::numeric_limits<double>::infinity();
  Matrix6d information = Matrix6d::Zero();  ///< sum of weight J^T J
};

/// When the fit stops, and how many of the points it looks at.
struct MixtureOptions {
  int max_iterations = 30;
  double step_tolerance = 1e-6;  ///< radians, and part of the range
  std::size_t points = std::numeric_limits<std::size_t>::max();
};

/// Expectation maximisation with Gauss-Newton steps from the mode's pose, outlier share and law,
/// beginning with noise of `scale`. False where fewer than three points are left or they do not
/// determine the pose; the mode is then not to be used.
///
/// Noise that is not known is the most probable under the prior of noise.h, and at most
/// kWidestNoise: clutter is not explained by large noise.
bool fit_mixture(const Cloud& cloud, double scale, const MixtureOptions& options, Mode& mode);

inline constexpr double kWidestNoise = 0.03;

/// Beta prior of the share of outliers: pseudo-counts of outliers and inliers.
inline constexpr double kPriorOutliers = 1;
inline constexpr double kPriorInliers = 4;

}  // namespace sightline::consensus
