// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "pose/pose.h"

namespace sightline {

/// The poses of three points: at most four.
struct P3pPoses {
  std::array<Pose, 4> cam_from_target;
  std::size_t count = 0;

  std::span<const Pose> all() const& { return {cam_from_target.data(), count}; }
  void all() const&& = delete;  // of a temporary, which a loop over it would not keep alive
};

/// Every pose that puts three points (metres, any unit will do) on three rays of the camera, given
/// by vectors of any length, in front of the camera. None when a number is not finite, a ray has no
/// positive z, the points are collinear, two rays coincide, or there is no such pose. Two poses
/// that coincide may come twice. Where two solutions merge (a double root) each is accurate to the
/// square root of rounding.
///
/// Intersects two conics: Ding, Yang, Larsson, Olsson, Astrom, "Revisiting the P3P problem", CVPR
/// 2023, after Persson and Nordberg, "Lambda Twist", ECCV 2018. What is ours stands in p3p.cpp.
P3pPoses p3p(const std::array<Eigen::Vector3d, 3>& points_in_target,
             const std::array<Eigen::Vector3d, 3>& rays_in_cam);

}  // namespace sightline
