// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Arun, Huang, Blostein 1987: with B = U S V^T the best orthonormal matrix is U V^T. Where it is a
// reflection and the points are coplanar (s3 = 0), its twin across the plane is the rotation; where
// they are not, the method fails: kReflection. Needs points that are not collinear.

#include <Eigen/LU>
#include <Eigen/SVD>

#include "pose/orientation/methods.h"

namespace sightline {

OrientationEstimate orient_by_arun(const PairMoments& moments) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moments.cross,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d& s = svd.singularValues();
  const double nothing = smallest_gap(moments, s[0]);
  if (!(s[1] > nothing)) return {OrientationStatus::kDegenerate, {}};
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV()).determinant() < 0) {
    if (s[2] > nothing) return {OrientationStatus::kReflection, {}};
    u.col(2) *= -1;
  }
  return estimate_about_means(moments, u * svd.matrixV().transpose());
}

}  // namespace sightline
