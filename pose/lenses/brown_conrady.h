// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Core>

namespace sightline {

/// Lens distortion after Brown (1966) and Conrady (1919), with the coefficients and signs of
/// OpenCV: x_d = x (1 + k1 r2 + k2 r4 + k3 r6) + 2 p1 x y + p2 (r2 + 2 x2), and alike for y.
/// It can be undone out to its fold, where the determinant of its derivative falls to 0.
struct BrownConrady {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  bool is_zero() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0; }
  bool operator==(const BrownConrady&) const = default;
};

// What each lens model must offer; lens.h says what the functions mean.
Eigen::Vector2d distorted(const BrownConrady& lens, const Eigen::Vector2d& normalised);
Eigen::Matrix2d distortion_jacobian(const BrownConrady& lens, const Eigen::Vector2d& normalised);
std::optional<Eigen::Vector2d> undistorted(const BrownConrady& lens, const Eigen::Vector2d& image);
double fold_radius(const BrownConrady& lens, double limit);

}  // namespace sightline
