// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A cube and poses of it, whose errors can be worked out by hand; millimetres.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "pose/pose.h"

namespace sightline {

inline constexpr double kRounding = 1e-9;  // mm and px, of coordinates up to 1e3
inline const std::vector<Pose> kNoSymmetry{Pose{}};

// The eight corners of a cube of 100 mm about the origin.
inline Eigen::Matrix3Xd cube_points() {
  Eigen::Matrix3Xd points(3, 8);
  for (int i = 0; i < 8; ++i) {
    points.col(i) << (i & 1 ? 50 : -50), (i & 2 ? 50 : -50), (i & 4 ? 50 : -50);
  }
  return points;
}

inline Pose at_1000_mm(const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity()) {
  return {rotation, {0, 0, 1000}};
}

inline Pose shifted(Pose pose, const Eigen::Vector3d& by_mm) {
  pose.translation += by_mm;
  return pose;
}

inline Eigen::Matrix3d turn_z(double angle_rad) {
  return rotation_from_vector({0, 0, angle_rad});
}

inline Eigen::Matrix3d k_of(double f, double c) {
  Eigen::Matrix3d k;
  k << f, 0, c, 0, f, c, 0, 0, 1;
  return k;
}

}  // namespace sightline
