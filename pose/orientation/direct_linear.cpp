// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// The direct way: x_b = M x_a + t as a linear system for twelve unknowns, by least squares
// M = B S^-1 with S = sum w (x_a - mean)(x_a - mean)^T, then the rotation nearest to M by an SVD.
// Under noise it is worse than the other methods, which know that M is a rotation. Needs four
// points that are not coplanar (kDegenerate); kReflection where M mirrors.

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "pose/orientation/methods.h"

namespace sightline {
namespace {

/// The squared thickness of the cloud over its squared length below which it is a plane.
constexpr double kSmallestSpread = 1e-12;

}  // namespace

OrientationEstimate orient_by_direct_linear(const PairMoments& moments) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(moments.spread_a);
  const Eigen::Vector3d& extents2 = spread.eigenvalues();  // ascending
  if (!(extents2[0] > std::max(kSmallestSpread * extents2[2], moments.rounding))) {
    return {OrientationStatus::kDegenerate, {}};
  }
  const Eigen::Matrix3d affine = moments.cross * spread.eigenvectors() *
                                 extents2.cwiseInverse().asDiagonal() *
                                 spread.eigenvectors().transpose();
  if (affine.determinant() < 0) return {OrientationStatus::kReflection, {}};
  const SvdRotation svd = rotation_by_svd(affine, 0);
  if (svd.status != OrientationStatus::kOk) return {svd.status, {}};
  return estimate_about_means(moments, svd.rotation);
}

}  // namespace sightline
