// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include <Eigen/Core>

namespace sightline {

/// The arithmetic mean of points; there must be one.
Eigen::Vector3d mean_of(std::span<const Eigen::Vector3d> points);

/// The principal axes of a cloud of points about its mean, longest first.
struct PointSpread {
  Eigen::Vector3d mean;
  Eigen::Matrix3d axes;  ///< columns: a right-handed orthonormal frame
  Eigen::Vector3d sd;    ///< along the axes, descending (not divided by n: roots of the sums)

  bool is_collinear() const { return !(sd[1] > 1e-6 * sd[0]); }
  bool is_nearly_planar() const { return sd[2] < 0.1 * sd[1]; }
};

PointSpread spread_of(std::span<const Eigen::Vector3d> points);

}  // namespace sightline
