// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Where the solvers begin when nobody tells them where the target is.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "pose/pose.h"
#include "pose/reprojection.h"

namespace sightline {

/// Whether points are clearly not in a plane: false for nearly planar clouds
/// (PointSpread::is_nearly_planar), and for some others.
bool is_clearly_solid(std::span<const Eigen::Vector3d> points);

/// The same by the sum of p p^T of points p about their mean.
bool is_clearly_solid(const Eigen::Matrix3d& scatter);

/// The scaled-orthographic pose of a target that is clearly not planar and so far away that least
/// squares needs no better start (kWeakPerspective in pose/starts.cpp), as cam_from_centred; none
/// otherwise.
std::optional<Pose> weak_perspective_start(const Correspondences& c);

/// Where the solvers begin, as cam_from_centred: at the initial pose if there is one, else at the
/// weak_perspective_start where that will do, else at what orthogonal iteration finds, which may
/// be two mirror poses. Empty when no start has all points in front of the camera.
std::vector<Pose> starting_poses(const Correspondences& c,
                                 const std::optional<Pose>& initial_cam_from_target);

}  // namespace sightline
