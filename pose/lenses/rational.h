// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Core>

namespace sightline {

/// OpenCV's rational lens with its thin prism: with the radial factor
/// q = (1 + k1 r2 + k2 r4 + k3 r6) / (1 + k4 r2 + k5 r4 + k6 r6),
/// x_d = x q + 2 p1 x y + p2 (r2 + 2 x2) + s1 r2 + s2 r4 and
/// y_d = y q + p1 (r2 + 2 y2) + 2 p2 x y + s3 r2 + s4 r4.
/// It can be undone out to the first radius at which its derivative turns the image over or the
/// denominator falls to 0. OpenCV's tilt of the sensor (tau_x, tau_y) is not modelled.
struct RationalLens {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0;
  double s1 = 0, s2 = 0, s3 = 0, s4 = 0;
  bool operator==(const RationalLens&) const = default;
};

// What each lens model must offer; lens.h says what the functions mean. Beyond the denominator's
// zero the derivative is zero, which says that nothing can be undone there.
Eigen::Vector2d distorted(const RationalLens& lens, const Eigen::Vector2d& normalised);
Eigen::Matrix2d distortion_jacobian(const RationalLens& lens, const Eigen::Vector2d& normalised);
std::optional<Eigen::Vector2d> undistorted(const RationalLens& lens, const Eigen::Vector2d& image);
double fold_radius(const RationalLens& lens, double limit);

}  // namespace sightline
