// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/pose_law.h"

#include <numbers>

#include "pose/attitude.h"

namespace sightline {

Pose pose_from(const Eigen::Vector3d& theta_deg, const Eigen::Vector3d& t_m) {
  const Eigen::Vector3d theta = theta_deg * (std::numbers::pi / 180);
  return {rotation_from_attitude({theta.x(), theta.y(), theta.z()}), t_m};
}

Pose drawn_pose(const PoseLaw& law, RandomStream& stream) {
  const auto draw = [&stream](const PoseLaw::Range& r) { return stream.uniform(r.min, r.max); };
  Pose pose;
  if (law.is_attitude_uniform) {
    pose.rotation = stream.rotation();
  } else {
    Eigen::Vector3d theta_deg;
    for (double& angle : theta_deg) angle = draw(law.drawn_angle_deg);
    pose = pose_from(theta_deg, Eigen::Vector3d::Zero());
  }
  pose.translation.x() = draw(law.drawn_lateral_m);
  pose.translation.y() = draw(law.drawn_lateral_m);
  pose.translation.z() = draw(law.drawn_range_m);
  return pose;
}

}  // namespace sightline
