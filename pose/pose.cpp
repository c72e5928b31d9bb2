// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/pose.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace sightline {
namespace {

constexpr double kOrthonormalTolerance = 1e-9;

Eigen::Quaterniond quaternion_from_rotation(const Eigen::Matrix3d& rotation) {
  return Eigen::Quaterniond(rotation).normalized();
}

}  // namespace

Pose operator*(const Pose& c_from_b, const Pose& b_from_a) {
  return {c_from_b.rotation * b_from_a.rotation, c_from_b * b_from_a.translation};
}

Pose inverse(const Pose& b_from_a) {
  const Eigen::Matrix3d transposed = b_from_a.rotation.transpose();
  return {transposed, -(transposed * b_from_a.translation)};
}

bool is_valid(const Pose& b_from_a) {
  const Eigen::Matrix3d& r = b_from_a.rotation;
  if (!r.allFinite() || !b_from_a.translation.allFinite()) return false;
  const Eigen::Matrix3d excess = r.transpose() * r - Eigen::Matrix3d::Identity();
  return excess.cwiseAbs().maxCoeff() <= kOrthonormalTolerance && r.determinant() > 0;
}

Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& w_rad) {
  const double half_angle = 0.5 * w_rad.stableNorm();
  // sin(x)/x is 1 to rounding long before x underflows.
  const double sinc = half_angle > 1e-9 ? std::sin(half_angle) / half_angle : 1.0;
  const Eigen::Vector3d v = (0.5 * sinc) * w_rad;
  return Eigen::Quaterniond(std::cos(half_angle), v.x(), v.y(), v.z())
      .normalized()
      .toRotationMatrix();
}

Eigen::Vector3d vector_from_rotation(const Eigen::Matrix3d& rotation) {
  // The quaternion, not the trace: the arc cosine of the trace loses half the digits near 0 and pi.
  const Eigen::Vector4d wxyz = quaternion_wxyz(rotation);
  const Eigen::Vector3d v = wxyz.tail<3>();
  const double sine = v.stableNorm();
  if (sine < 1e-9) return 2 * v;
  return (2 * std::atan2(sine, wxyz[0]) / sine) * v;
}

Pose retract(const Pose& pose, const Vector6d& delta) {
  return {rotation_from_vector(delta.head<3>()) * pose.rotation,
          pose.translation + delta.tail<3>()};
}

Vector6d change_between(const Pose& from, const Pose& to) {
  Vector6d change;
  change << vector_from_rotation(to.rotation * from.rotation.transpose()),
      to.translation - from.translation;
  return change;
}

double geodesic_angle_rad(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Eigen::Quaterniond a_from_b = quaternion_from_rotation(a.transpose() * b);
  return 2 * std::atan2(a_from_b.vec().norm(), std::abs(a_from_b.w()));
}

Eigen::Vector4d quaternion_wxyz(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q = quaternion_from_rotation(rotation);
  const Eigen::Vector4d wxyz(q.w(), q.x(), q.y(), q.z());
  return wxyz[0] < 0 ? Eigen::Vector4d(-wxyz) : wxyz;
}

Eigen::Matrix3d rotation_from_quaternion_wxyz(const Eigen::Vector4d& quaternion) {
  const Eigen::Vector4d q = quaternion.stableNormalized();
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

}  // namespace sightline
