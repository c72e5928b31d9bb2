// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Umeyama 1991: with B = U S V^T the best rotation is A = U diag(1, 1, det(U) det(V)) V^T, a proper
// one for mirrored points too. Needs points that are not collinear.

#include <Eigen/LU>
#include <Eigen/SVD>

#include "pose/orientation/methods.h"

namespace sightline {

SvdRotation rotation_by_svd(const Eigen::Matrix3d& b, double smallest_gap) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(b, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV()).determinant() < 0 ? -1.0 : 1.0;
  const Eigen::Vector3d& s = svd.singularValues();
  const double gap = s[1] + sign * s[2];
  SvdRotation result;
  if (!(gap > std::max(kDegenerateGap * s[0], smallest_gap))) return result;
  result.status = OrientationStatus::kOk;
  result.rotation =
      svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  result.trace = s[0] + gap;
  return result;
}

OrientationEstimate orient_by_umeyama(const PairMoments& moments) {
  const SvdRotation svd = rotation_by_svd(moments.cross, moments.rounding);
  if (svd.status != OrientationStatus::kOk) return {svd.status, {}};
  return estimate_about_means(moments, svd.rotation);
}

}  // namespace sightline
