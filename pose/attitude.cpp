// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/attitude.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

namespace sightline {
namespace {

/// Below this cosine of the yaw its digits are rounding only, and with them those of the roll.
constexpr double kGimbalLockCosine = 16 * std::numeric_limits<double>::epsilon();

double wrapped_to_pi(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}

}  // namespace

Eigen::Matrix3d rotation_from_attitude(const Attitude& theta) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(theta.roll_rad, Vector3d::UnitZ()).toRotationMatrix() *
          AngleAxisd(theta.yaw_rad, Vector3d::UnitY()).toRotationMatrix() *
          AngleAxisd(theta.pitch_rad, Vector3d::UnitX()).toRotationMatrix());
}

Attitude attitude_from_rotation(const Eigen::Matrix3d& rotation) {
  const Eigen::Matrix3d& r = rotation;
  const double cos_yaw = std::hypot(r(0, 0), r(1, 0));
  const double yaw = std::atan2(-r(2, 0), cos_yaw);
  const double roll = cos_yaw < kGimbalLockCosine ? 0.0 : std::atan2(r(1, 0), r(0, 0));
  // Pitch from Rz(-roll) R = Ry Rx rather than from the last row: what roll loses near gimbal lock,
  // pitch then makes good, and the angles always give back the rotation.
  const double s = std::sin(roll);
  const double c = std::cos(roll);
  const double pitch = std::atan2(s * r(0, 2) - c * r(1, 2), c * r(1, 1) - s * r(0, 1));
  return {pitch, yaw, roll};
}

double attitude_error_rad(const Eigen::Matrix3d& estimated, const Eigen::Matrix3d& truth) {
  const Attitude a = attitude_from_rotation(estimated);
  const Attitude b = attitude_from_rotation(truth);
  const Eigen::Vector3d difference(wrapped_to_pi(a.pitch_rad - b.pitch_rad),
                                   wrapped_to_pi(a.yaw_rad - b.yaw_rad),
                                   wrapped_to_pi(a.roll_rad - b.roll_rad));
  return difference.norm() / std::sqrt(3.0);
}

double translation_error_fraction(const Eigen::Vector3d& estimated, const Eigen::Vector3d& truth) {
  return (estimated - truth).norm() / std::sqrt(3.0) / truth.norm();
}

}  // namespace sightline
