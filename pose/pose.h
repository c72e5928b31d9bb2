// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sightline {

/// A small change (w, dt) of a pose: w a rotation vector in radians, dt in metres; and matrices
/// over such changes, as are covariances of a pose.
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A rigid transform that takes coordinates in frame a to coordinates in frame b.
/// Variables of this type are named `b_from_a`, points `x_in_a`, so that frames cancel:
/// `x_in_cam = cam_from_target * x_in_target`. The rotation must be proper orthonormal.
struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x_in_a) const {
    return rotation * x_in_a + translation;
  }
};

/// c_from_a = c_from_b * b_from_a.
Pose operator*(const Pose& c_from_b, const Pose& b_from_a);

/// a_from_b.
Pose inverse(const Pose& b_from_a);

/// True when every number is finite and the rotation is orthonormal with determinant +1
/// to 1e-9 (a product of a million double rotations stays within it).
bool is_valid(const Pose& b_from_a);

/// The rotation by |w| radians about w (Rodrigues). Exact to rounding for every w.
Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& w_rad);

/// The inverse of rotation_from_vector, |w| in [0, pi]. Stable near 0 and near pi.
Eigen::Vector3d vector_from_rotation(const Eigen::Matrix3d& rotation);

/// The pose (Exp(w) R, t + dt) that the change delta = (w, dt) leads to from the pose (R, t).
Pose retract(const Pose& pose, const Vector6d& delta);

/// The change that leads from one pose to the other: retract(from, change) is `to`.
Vector6d change_between(const Pose& from, const Pose& to);

/// The angle in [0, pi] of the rotation that takes one attitude to the other. Unlike a difference
/// of Euler angles it has no gimbal lock. Accurate to 1e-15 rad near 0 and near pi.
double geodesic_angle_rad(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

/// The unit quaternion (w, x, y, z), scalar first and w >= 0, as files store it. (A half turn, w =
/// 0, has two such quaternions; either may come.)
Eigen::Vector4d quaternion_wxyz(const Eigen::Matrix3d& rotation);

/// The rotation of a quaternion (w, x, y, z) of any length but zero.
Eigen::Matrix3d rotation_from_quaternion_wxyz(const Eigen::Vector4d& quaternion);

}  // namespace sightline
