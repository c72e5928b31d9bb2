// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

namespace sightline {

/// What a camera sees of space: z from `near_m`, and rays (x/z, y/z) within `low` to `high`.
struct ViewPyramid {
  double near_m = 0;
  Eigen::Vector2d low = Eigen::Vector2d::Zero();
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
};

/// The corners of what of a triangle (camera's axes) lies within the pyramid, in its own order:
/// none, or a convex polygon (Sutherland and Hodgman, Reentrant polygon clipping, 1974). Two
/// triangles that share an edge are cut at the same points of it, bit for bit, so that no gap opens
/// between them.
std::vector<Eigen::Vector3d> clipped(const std::array<Eigen::Vector3d, 3>& triangle,
                                     const ViewPyramid& pyramid);

}  // namespace sightline
