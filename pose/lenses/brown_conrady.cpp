// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/lenses/brown_conrady.h"

#include "pose/lenses/newton.h"

namespace sightline {

Eigen::Vector2d distorted(const BrownConrady& lens, const Eigen::Vector2d& normalised) {
  const double x = normalised.x();
  const double y = normalised.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  return {x * radial + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x),
          y * radial + lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y};
}

Eigen::Matrix2d distortion_jacobian(const BrownConrady& lens, const Eigen::Vector2d& normalised) {
  const double x = normalised.x();
  const double y = normalised.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  const double slope =
      2 * (lens.k1 + r2 * (2 * lens.k2 + r2 * 3 * lens.k3));  // d radial / d r2 * 2
  const double mixed = slope * x * y + 2 * lens.p1 * x + 2 * lens.p2 * y;
  Eigen::Matrix2d jacobian;
  jacobian << radial + slope * x * x + 2 * lens.p1 * y + 6 * lens.p2 * x, mixed,  //
      mixed, radial + slope * y * y + 6 * lens.p1 * y + 2 * lens.p2 * x;
  return jacobian;
}

std::optional<Eigen::Vector2d> undistorted(const BrownConrady& lens, const Eigen::Vector2d& image) {
  return lenses::undistorted_by_newton(lens, image);
}

double fold_radius(const BrownConrady& lens, double limit) {
  return lenses::first_fold(limit, [&lens](const Eigen::Vector2d& at) {
    return distortion_jacobian(lens, at).determinant() <= 0;
  });
}

}  // namespace sightline
