// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/lenses/rational.h"

#include "pose/lenses/newton.h"

namespace sightline {

Eigen::Vector2d distorted(const RationalLens& lens, const Eigen::Vector2d& normalised) {
  const double x = normalised.x();
  const double y = normalised.y();
  const double r2 = x * x + y * y;
  const double radial = (1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))) /
                        (1 + r2 * (lens.k4 + r2 * (lens.k5 + r2 * lens.k6)));
  return {
      x * radial + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x) + r2 * (lens.s1 + r2 * lens.s2),
      y * radial + lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y +
          r2 * (lens.s3 + r2 * lens.s4)};
}

Eigen::Matrix2d distortion_jacobian(const RationalLens& lens, const Eigen::Vector2d& normalised) {
  const double x = normalised.x();
  const double y = normalised.y();
  const double r2 = x * x + y * y;
  const double below = 1 + r2 * (lens.k4 + r2 * (lens.k5 + r2 * lens.k6));
  if (!(below > 0)) return Eigen::Matrix2d::Zero();
  const double radial = (1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))) / below;
  const double above_slope = lens.k1 + r2 * (2 * lens.k2 + r2 * 3 * lens.k3);
  const double below_slope = lens.k4 + r2 * (2 * lens.k5 + r2 * 3 * lens.k6);
  const double slope = 2 * (above_slope - radial * below_slope) / below;  // d radial / d r2 * 2
  const double mixed = slope * x * y + 2 * lens.p1 * x + 2 * lens.p2 * y;
  const double prism_x = 2 * (lens.s1 + 2 * lens.s2 * r2);
  const double prism_y = 2 * (lens.s3 + 2 * lens.s4 * r2);
  Eigen::Matrix2d jacobian;
  jacobian << radial + slope * x * x + 2 * lens.p1 * y + 6 * lens.p2 * x + prism_x * x,
      mixed + prism_x * y, mixed + prism_y * x,
      radial + slope * y * y + 6 * lens.p1 * y + 2 * lens.p2 * x + prism_y * y;
  return jacobian;
}

std::optional<Eigen::Vector2d> undistorted(const RationalLens& lens, const Eigen::Vector2d& image) {
  return lenses::undistorted_by_newton(lens, image);
}

double fold_radius(const RationalLens& lens, double limit) {
  return lenses::first_fold(limit, [&lens](const Eigen::Vector2d& at) {
    const Eigen::Matrix2d jacobian = distortion_jacobian(lens, at);
    return !(jacobian.determinant() > 0 && jacobian.trace() > 0);
  });
}

}  // namespace sightline
