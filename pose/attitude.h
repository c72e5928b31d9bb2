// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sightline {

/// The attitude angles of the ORPE paper, theta = (pitch, yaw, roll) about x, y, z:
/// R = Rz(roll) Ry(yaw) Rx(pitch). The paper prints no order; this one is ours.
struct Attitude {
  double pitch_rad = 0;
  double yaw_rad = 0;
  double roll_rad = 0;
};

Eigen::Matrix3d rotation_from_attitude(const Attitude& theta);

/// The angles of a rotation, yaw in [-pi/2, pi/2]. In gimbal lock (|yaw| = pi/2) only pitch -+ roll
/// is determined; roll is then taken as zero. Compare poses by geodesic_angle_rad as well.
Attitude attitude_from_rotation(const Eigen::Matrix3d& rotation);

/// theta_error of the ORPE paper (section 4): the root mean square of the three differences of the
/// attitude angles, each wrapped to [-pi, pi]. Meaningless near gimbal lock.
double attitude_error_rad(const Eigen::Matrix3d& estimated, const Eigen::Matrix3d& truth);

/// T_error of the ORPE paper (section 4): the root mean square of the three components of the
/// translation error, over the imaging distance |true translation|; a fraction, not percent.
double translation_error_fraction(const Eigen::Vector3d& estimated, const Eigen::Vector3d& truth);

}  // namespace sightline
