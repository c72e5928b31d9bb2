// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Horn 1987: tr(R(q)^T B) = q^T N q for a unit quaternion q, N a symmetric 4x4 matrix of the
// elements of B; the best q is the eigenvector of N's largest eigenvalue, s1 + s2 + s3 (s3 with the
// sign of det B). The next is s1 - s2 - s3: where they meet, the rotation is not determined.
// Always a rotation. Needs points that are not collinear.

#include <Eigen/Eigenvalues>

#include "pose/orientation/methods.h"

namespace sightline {
namespace {

/// N for q = (w, x, y, z).
Eigen::Matrix4d quaternion_form(const Eigen::Matrix3d& b) {
  Eigen::Matrix4d n;
  n(0, 0) = b.trace();
  n.bottomRightCorner<3, 3>() = b + b.transpose() - b.trace() * Eigen::Matrix3d::Identity();
  n.bottomLeftCorner<3, 1>() =
      Eigen::Vector3d(b(2, 1) - b(1, 2), b(0, 2) - b(2, 0), b(1, 0) - b(0, 1));
  n.topRightCorner<1, 3>() = n.bottomLeftCorner<3, 1>().transpose();
  return n;
}

}  // namespace

OrientationEstimate orient_by_horn_quaternion(const PairMoments& moments) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(quaternion_form(moments.cross));
  const Eigen::Vector4d& values = eigen.eigenvalues();  // ascending
  if (!(values[3] - values[2] > 2 * smallest_gap(moments, values[3]))) {
    return {OrientationStatus::kDegenerate, {}};
  }
  return estimate_about_means(moments, rotation_from_quaternion_wxyz(eigen.eigenvectors().col(3)));
}

}  // namespace sightline
