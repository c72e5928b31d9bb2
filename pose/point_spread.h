// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include <Eigen/Core>

namespace sightline {

/// The arithmetic mean of points; there must be one.
Eigen::Vector3d mean_of(std::span<const Eigen::Vector3d> points);

/// The sum of p p^T of points p.
struct Moments {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  void add(const Eigen::Vector3d& p) {
    xx += p.x() * p.x();
    xy += p.x() * p.y();
    xz += p.x() * p.z();
    yy += p.y() * p.y();
    yz += p.y() * p.z();
    zz += p.z() * p.z();
  }
  Eigen::Matrix3d matrix() const;
};

Eigen::Matrix3d moments_of(std::span<const Eigen::Vector3d> points);

/// The sum of the products of two eigenvalues of a symmetric matrix.
double second_invariant(const Eigen::Matrix3d& m);

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
