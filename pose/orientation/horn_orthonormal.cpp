// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Horn, Hilden, Negahdaripour 1988: A = B (B^T B)^-1/2 by the eigenvectors v_i of B^T B, that is
// A = sum u_i v_i^T with u_i = B v_i / s_i. Deviation: u_3 is always u_1 x u_2 (the paper does so
// where s3 = 0), which gives the best rotation also for mirrored points, where B (B^T B)^-1/2 is a
// reflection. B^T B holds the squares of the singular values, so that half the digits of the small
// ones are lost: needs a gap of 1e-5, and flags less as kDegenerate.

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "pose/orientation/methods.h"

namespace sightline {
namespace {

constexpr double kSmallestRelativeGap = 1e-5;

}  // namespace

OrientationEstimate orient_by_horn_orthonormal(const PairMoments& moments) {
  const Eigen::Matrix3d& b = moments.cross;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(b.transpose() * b);
  const Eigen::Vector3d s = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();  // ascending
  const double gap = b.determinant() < 0 ? s[1] - s[0] : s[1] + s[0];
  if (!(gap > std::max(kSmallestRelativeGap * s[2], moments.rounding))) {
    return {OrientationStatus::kDegenerate, {}};
  }
  Eigen::Matrix3d u, v;
  v.col(0) = eigen.eigenvectors().col(2);
  v.col(1) = eigen.eigenvectors().col(1);
  v.col(2) = v.col(0).cross(v.col(1));
  u.col(0) = (b * v.col(0)).normalized();
  const Eigen::Vector3d second = b * v.col(1);
  u.col(1) = (second - u.col(0).dot(second) * u.col(0)).normalized();
  u.col(2) = u.col(0).cross(u.col(1));
  return estimate_about_means(moments, u * v.transpose());
}

}  // namespace sightline
