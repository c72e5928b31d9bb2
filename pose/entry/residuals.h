// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What the residuals of the points that a solver kept say of its pose.
#pragma once

#include <cstddef>

#include "pose/solver.h"

namespace sightline::entry {

/// The residuals of the kept points, whitened where there are covariances.
struct Residuals {
  std::size_t kept = 0;
  double squares = 0;      ///< their sum; infinite where a point is behind the camera
  double largest = 0;      ///< the largest of the squares
  double squares_px2 = 0;  ///< both in pixels
  double largest_px2 = 0;
  double sigma = 0;     ///< of the noise in each coordinate; 0: not known
  double rounding = 0;  ///< squares below this are zero

  double degrees() const { return 2 * static_cast<double>(kept) - 6; }
  /// Whether noise as large has residuals as large in more than one of a thousand problems; where
  /// the noise is not known, whether the largest is as large for noise of the size of the others.
  bool look_like_noise() const;
};

/// At a pose, or at that of the estimate, for the points that the estimate keeps.
Residuals residuals_of(const PoseProblem& problem, const PoseEstimate& estimate,
                       const Pose& cam_from_target);
Residuals residuals_of(const PoseProblem& problem, const PoseEstimate& estimate);

/// Whether the challenger's noise is smaller than that of the holder beyond chance: the ratio of
/// the variances is above twice about the quantile of 1e-4 of Fisher's law, from both of its ends
/// (few degrees of freedom, and many, where the logarithm is normal).
bool is_clearly_better(const Residuals& challenger, const Residuals& holder);

}  // namespace sightline::entry
