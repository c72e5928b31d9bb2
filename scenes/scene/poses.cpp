// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/poses.h"

#include <numbers>

#include <Eigen/Geometry>

#include "pose/angles.h"
#include "pose/attitude.h"

namespace sightline {
namespace {

// Keys of poses that are drawn.
constexpr const char* kDrawnKeys[] = {"angle_deg", "attitude", "tilt_deg",   "lateral_m",
                                      "range_m",   "aim_m",    "max_redraws"};

void read_fixed_poses(const std::vector<TomlTable>& fixed, PoseLaw& law) {
  for (const TomlTable& table : fixed) {
    FixedPose pose;
    for (const Key& key : keys_of(pose)) read_key(table, key);
    law.theta_deg.push_back(pose.theta_deg);
    law.t_m.push_back(pose.t_m);
  }
}

void read_attitude(const TomlTable& table, std::span<const Key> keys, PoseLaw& law) {
  read_key(table, find_key(keys, "attitude"));
  if (!law.is_attitude_uniform) {
    law.drawn_angle_deg = read_range(table, "angle_deg", find_key(keys, "angle_deg").allowed);
  } else if (table.has("angle_deg")) {
    table.fail("angle_deg", "cannot stand beside attitude = \"uniform\"");
  }
  if (table.has("tilt_deg") && !law.is_attitude_uniform) {
    table.fail("tilt_deg", "needs attitude = \"uniform\" beside it");
  }
  read_key(table, find_key(keys, "tilt_deg"));
}

// Uniform about both z axes, which make an angle of the range.
Eigen::Matrix3d tilted_attitude(const Range& tilt_deg, RandomStream& stream) {
  const auto turn = [](double angle, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  };
  const double before = stream.uniform(0, 2 * std::numbers::pi);
  const double tilt = tilt_deg.draw(stream) * kDegree;
  const double after = stream.uniform(0, 2 * std::numbers::pi);
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  return turn(after, z) * turn(tilt, Eigen::Vector3d::UnitY()) * turn(before, z);
}

}  // namespace

std::vector<Key> keys_of(FixedPose& pose) {
  return {
      {"poses.fixed",
       "theta_deg",
       &pose.theta_deg,
       {},
       "deg",
       "pitch, yaw, roll about x, y, z of the camera",
       {},
       "cam_from_target",
       true},
      {"poses.fixed",
       "t_m",
       &pose.t_m,
       {},
       "m",
       "where the target's origin is in the camera's axes",
       {},
       "cam_from_target",
       true},
  };
}

std::vector<Key> keys_of(PoseLaw& law) {
  return {
      {"poses",
       "lateral_jitter_m",
       &law.lateral_jitter_m,
       {0, 1e6},
       "m",
       "added to x and y of a pose of [[poses.fixed]], uniform within +-",
       {},
       "cam_from_target"},
      {"poses",
       "max_redraws",
       &law.max_redraws,
       {0, 100000},
       "",
       "times that a drawn pose with a feature outside the image is drawn anew",
       {},
       "cam_from_target"},
      {"poses",
       "attitude",
       choice(law.is_attitude_uniform, {{"angles", false}, {"uniform", true}}),
       {},
       "",
       "how attitudes are drawn: by angle_deg, or uniform on SO(3)",
       {},
       "cam_from_target"},
      {"poses",
       "angle_deg",
       LowHigh{&law.drawn_angle_deg},
       {-180, 180},
       "deg",
       "each of the three angles of a drawn attitude",
       {},
       "cam_from_target",
       false,
       "required by attitude = \"angles\""},
      {"poses",
       "tilt_deg",
       &law.tilt_deg,
       {0, 180},
       "deg",
       "of a uniform attitude: the angle between the target's z axis and the camera's",
       {},
       "cam_from_target"},
      {"poses",
       "lateral_m",
       LowHigh{&law.drawn_lateral_m},
       {-1e6, 1e6},
       "m",
       "x and y of a drawn pose",
       {},
       "cam_from_target",
       false,
       "required without [[poses.fixed]]"},
      {"poses",
       "range_m",
       LowHigh{&law.drawn_range_m},
       {1e-3, 1e9},
       "m",
       "z of a drawn pose",
       {},
       "cam_from_target",
       false,
       "required without [[poses.fixed]]"},
      {"poses",
       "aim_m",
       &law.aim_m,
       {-1e9, 1e9},
       "m",
       "the point of the target that lateral_m and range_m place, in its own axes",
       {},
       "cam_from_target"},
  };
}

PoseLaw read_poses(const TomlTable& table) {
  const auto fixed = table.tables("fixed");
  PoseLaw law;
  const std::vector<Key> keys = keys_of(law);
  read_key(table, find_key(keys, "lateral_jitter_m"));
  read_key(table, find_key(keys, "max_redraws"));
  if (!fixed.empty()) {
    for (const char* key : kDrawnKeys) {
      if (table.has(key))
        table.fail(key, "cannot stand beside [[poses.fixed]]: give one or the other");
    }
    read_fixed_poses(fixed, law);
    return law;
  }
  if (!table.has("range_m")) {
    table.fail("fixed",
               "is missing: give [[poses.fixed]], or the ranges angle_deg, lateral_m and "
               "range_m to draw from");
  }
  if (table.has("lateral_jitter_m")) table.fail("lateral_jitter_m", "belongs to [[poses.fixed]]");
  read_attitude(table, keys, law);
  read_position_ranges(table, law);
  read_key(table, find_key(keys, "aim_m"));
  return law;
}

void read_position_ranges(const TomlTable& poses, PoseLaw& law) {
  const std::vector<Key> keys = keys_of(law);
  law.drawn_lateral_m = read_range(poses, "lateral_m", find_key(keys, "lateral_m").allowed);
  law.drawn_range_m = read_range(poses, "range_m", find_key(keys, "range_m").allowed);
}

Pose pose_from(const Eigen::Vector3d& theta_deg, const Eigen::Vector3d& t_m) {
  const Eigen::Vector3d theta = theta_deg * kDegree;
  return {rotation_from_attitude({theta.x(), theta.y(), theta.z()}), t_m};
}

Pose drawn_pose(const PoseLaw& law, RandomStream& stream) {
  Pose pose;
  if (law.tilt_deg) {
    pose.rotation = tilted_attitude(*law.tilt_deg, stream);
  } else if (law.is_attitude_uniform) {
    pose.rotation = stream.rotation();
  } else {
    Eigen::Vector3d theta_deg;
    for (double& angle : theta_deg) angle = law.drawn_angle_deg.draw(stream);
    pose = pose_from(theta_deg, Eigen::Vector3d::Zero());
  }
  pose.translation.x() = law.drawn_lateral_m.draw(stream);
  pose.translation.y() = law.drawn_lateral_m.draw(stream);
  pose.translation.z() = law.drawn_range_m.draw(stream);
  if (!law.aim_m.isZero(0)) pose.translation -= pose.rotation * law.aim_m;
  return pose;
}

Pose jittered_pose(const PoseLaw& law, int pose, RandomStream& stream) {
  const double dx = law.lateral_jitter_m * stream.uniform(-1, 1);
  const double dy = law.lateral_jitter_m * stream.uniform(-1, 1);
  return pose_from(law.theta_deg[pose], law.t_m[pose] + Eigen::Vector3d(dx, dy, 0));
}

}  // namespace sightline
