// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where the main target stands: the keys of [poses].
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "pose/pose.h"
#include "scenes/scene/keys.h"

namespace sightline {

/// A pose that a file gives, [[poses.fixed]].
struct FixedPose {
  Eigen::Vector3d theta_deg = Eigen::Vector3d::Zero();  ///< pitch, yaw, roll
  Eigen::Vector3d t_m = Eigen::Vector3d::Zero();
};

/// Poses that are given, or the ranges that poses are drawn from (uniform, in the file's units).
struct PoseLaw {
  /// One pose each; empty where poses are drawn. Pitch, yaw, roll in degrees; metres.
  std::vector<Eigen::Vector3d> theta_deg;
  std::vector<Eigen::Vector3d> t_m;
  /// Added to both lateral coordinates of a given pose, uniform in +-.
  double lateral_jitter_m = 0;
  bool is_attitude_uniform = false;  ///< uniform on SO(3), and drawn_angle_deg means nothing
  /// Of a uniform attitude: the angle between the target's z axis and the camera's, where given.
  std::optional<Range> tilt_deg;
  Range drawn_angle_deg;  ///< each of the three angles
  Range drawn_lateral_m;  ///< x and y of the point that is aimed at
  Range drawn_range_m;    ///< z of the point that is aimed at
  Eigen::Vector3d aim_m = Eigen::Vector3d::Zero();  ///< that point, in the target's frame
  int max_redraws = 100;  ///< of a drawn pose with a feature outside the image
};

std::vector<Key> keys_of(FixedPose& pose);
std::vector<Key> keys_of(PoseLaw& law);

/// What [poses] says. Throws InputError.
PoseLaw read_poses(const TomlTable& table);

/// The ranges of [poses] but for the angles. Throws InputError.
void read_position_ranges(const TomlTable& poses, PoseLaw& law);

/// cam_from_target of an attitude in degrees (pitch, yaw, roll) and a translation.
Pose pose_from(const Eigen::Vector3d& theta_deg, const Eigen::Vector3d& t_m);

/// A pose of the law's ranges.
Pose drawn_pose(const PoseLaw& law, RandomStream& stream);

/// One of the given poses, moved by its jitter.
Pose jittered_pose(const PoseLaw& law, int pose, RandomStream& stream);

}  // namespace sightline
