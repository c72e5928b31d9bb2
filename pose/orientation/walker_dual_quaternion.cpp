// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Walker, Shao, Volz 1991, for points: rotation and translation together as a dual quaternion
// (r, s), x_b = W(r)^T Q(r) x_a + W(r)^T s with points as pure quaternions (x, 0). The squared
// error is r^T C1 r + W s^T s + s^T C3 r + const with W the sum of the weights,
//
//   C1 = -2 sum w Q(x_b)^T W(x_a),   C3 = 2 sum w (W(x_a) - Q(x_b)),
//
// so that s = -C3 r / (2 W), and r is the eigenvector of the largest eigenvalue of
// A = (C3^T C3 / (2 W) - C1 - C1^T) / 2. Deviation: coordinates are taken from a point of each
// cloud and not from the frames' origins, which may lie far off; and where the clouds are of very
// different sizes, r is found with that of b brought to that of a, which does not change r: A holds
// the squares of both, and what is sought is their product. Always a rotation. Needs points that
// are not collinear.

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "pose/orientation/methods.h"

namespace sightline {
namespace {

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d k;
  k << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return k;
}

/// Q(x) with `sign` 1, W(x) with -1, of the pure quaternion (x, 0), vector part first.
Eigen::Matrix4d product_matrix(const Eigen::Vector3d& x, double sign) {
  Eigen::Matrix4d m;
  m << sign * cross_matrix(x), x, -x.transpose(), 0;
  return m;
}

Eigen::Matrix4d left(const Eigen::Vector3d& x) {
  return product_matrix(x, 1);
}

Eigen::Matrix4d right(const Eigen::Vector3d& x) {
  return product_matrix(x, -1);
}

/// sum w Q(x_b)^T W(x_a) from sum w x_b x_a^T: it is linear in both.
Eigen::Matrix4d sum_of_products(const Eigen::Matrix3d& sum_ba) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector3d e_i = Eigen::Vector3d::Unit(i);
      const Eigen::Vector3d e_j = Eigen::Vector3d::Unit(j);
      sum += sum_ba(i, j) * left(e_i).transpose() * right(e_j);
    }
  }
  return sum;
}

/// By what x_b is multiplied before r is sought: 1, or a power of two where the clouds' means
/// differ by more than a factor of 256.
double size_factor(const Eigen::Vector3d& mean_a, const Eigen::Vector3d& mean_b) {
  const double size_a = mean_a.norm();
  const double size_b = mean_b.norm();
  if (!(size_a > 0 && size_b > 0)) return 1;
  const int exponent = std::ilogb(size_a) - std::ilogb(size_b);
  return std::abs(exponent) <= 8 ? 1.0 : std::ldexp(1.0, std::clamp(exponent, -1000, 1000));
}

Eigen::Matrix4d c3_of(const PairMoments& moments, const Eigen::Vector3d& mean_a,
                      const Eigen::Vector3d& mean_b) {
  return 2 * moments.weight * (right(mean_a) - left(mean_b));
}

}  // namespace

OrientationEstimate orient_by_walker_dual_quaternion(const PairMoments& moments) {
  const Eigen::Vector3d mean_a = moments.mean_from_origin_a / moments.unit_m;
  const Eigen::Vector3d mean_b = moments.mean_from_origin_b / moments.unit_m;
  const double factor = size_factor(mean_a, mean_b);
  const Eigen::Vector3d sized_b = factor * mean_b;
  const Eigen::Matrix3d cross = factor * moments.cross;
  const Eigen::Matrix3d sum_ba = cross + moments.weight * sized_b * mean_a.transpose();
  const Eigen::Matrix4d c1 = -2 * sum_of_products(sum_ba);
  const Eigen::Matrix4d sized_c3 = c3_of(moments, mean_a, sized_b);
  const Eigen::Matrix4d a =
      0.5 * (sized_c3.transpose() * sized_c3 / (2 * moments.weight) - c1 - c1.transpose());

  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(a);
  const Eigen::Vector4d& values = eigen.eigenvalues();  // ascending; 4 (s2 + s3) between the last
  const double nothing = std::max(kDegenerateGap * cross.norm(), factor * moments.rounding);
  if (!(values[3] - values[2] > 4 * nothing)) return {OrientationStatus::kDegenerate, {}};
  const Eigen::Vector4d r = eigen.eigenvectors().col(3);
  const Eigen::Vector4d s = -c3_of(moments, mean_a, mean_b) * r / (2 * moments.weight);
  // t = vec(W(r)^T s)
  const Eigen::Vector3d t =
      r[3] * s.head<3>() - s[3] * r.head<3>() + r.head<3>().cross(s.head<3>());

  OrientationEstimate estimate{OrientationStatus::kOk, {}};
  estimate.b_from_a.rotation =
      rotation_from_quaternion_wxyz(Eigen::Vector4d(r[3], r[0], r[1], r[2]));
  estimate.b_from_a.translation =
      moments.origin_in_b + t * moments.unit_m - estimate.b_from_a.rotation * moments.origin_in_a;
  const bool is_finite =
      estimate.b_from_a.translation.allFinite() && estimate.b_from_a.rotation.allFinite();
  return is_finite ? estimate : OrientationEstimate{OrientationStatus::kDegenerate, {}};
}

}  // namespace sightline
