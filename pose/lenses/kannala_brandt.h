// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Core>

namespace sightline {

/// The fisheye lens of Kannala and Brandt (2006) as OpenCV's fisheye module has it: a ray at the
/// angle a to the optical axis is seen at the distance
/// d(a) = a (1 + k1 a2 + k2 a4 + k3 a6 + k4 a8)
/// from the axis, in its own direction. Coefficients of zero are the equidistant lens, which is no
/// pinhole. It can be undone out to the angle where d no longer grows, and short of 90 degrees:
/// cameras here see what lies in front of their plane (z > 0).
struct KannalaBrandt {
  double k1 = 0, k2 = 0, k3 = 0, k4 = 0;
  bool operator==(const KannalaBrandt&) const = default;
};

/// Rays farther than this from the axis are not told from those at 90 degrees, rad.
inline constexpr double kMostFisheyeAngle = 1.5707963267948966 - 1e-6;

// What each lens model must offer; lens.h says what the functions mean.
Eigen::Vector2d distorted(const KannalaBrandt& lens, const Eigen::Vector2d& normalised);
Eigen::Matrix2d distortion_jacobian(const KannalaBrandt& lens, const Eigen::Vector2d& normalised);
std::optional<Eigen::Vector2d> undistorted(const KannalaBrandt& lens, const Eigen::Vector2d& image);
double fold_radius(const KannalaBrandt& lens, double limit);

/// The angle at which the lens folds, or kMostFisheyeAngle where it does not until there, rad.
double fold_angle(const KannalaBrandt& lens);

}  // namespace sightline
