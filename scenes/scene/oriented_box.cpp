// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/oriented_box.h"

#include <cmath>

#include <Eigen/Geometry>

namespace sightline {
namespace {

bool are_apart_along(const Eigen::Vector3d& axis, const OrientedBox& a, const OrientedBox& b) {
  const double between = std::abs(axis.dot(b.middle - a.middle));
  const double reach_a = (axis.transpose() * a.half_axes).cwiseAbs().sum();
  const double reach_b = (axis.transpose() * b.half_axes).cwiseAbs().sum();
  return between > reach_a + reach_b;
}

}  // namespace

OrientedBox oriented_box(const Mesh& mesh, const Pose& cam_from_mesh) {
  Eigen::AlignedBox3d extent;
  for (const Eigen::Vector3d& vertex : mesh.vertices) extent.extend(vertex);
  const Eigen::Vector3d half = extent.sizes() / 2;
  return {cam_from_mesh * extent.center(), cam_from_mesh.rotation * half.asDiagonal()};
}

bool do_overlap(const OrientedBox& a, const OrientedBox& b) {
  for (int i = 0; i < 3; ++i) {
    // A flat box has no half axis across itself, but the cross product of the others.
    const Eigen::Vector3d face_a = a.half_axes.col((i + 1) % 3).cross(a.half_axes.col((i + 2) % 3));
    const Eigen::Vector3d face_b = b.half_axes.col((i + 1) % 3).cross(b.half_axes.col((i + 2) % 3));
    if (are_apart_along(face_a, a, b) || are_apart_along(face_b, a, b)) return false;
    // Of two flat boxes in one plane only their own axes lie in it.
    if (are_apart_along(a.half_axes.col(i), a, b) || are_apart_along(b.half_axes.col(i), a, b)) {
      return false;
    }
    for (int j = 0; j < 3; ++j) {
      if (are_apart_along(a.half_axes.col(i).cross(b.half_axes.col(j)), a, b)) return false;
    }
  }
  return true;
}

}  // namespace sightline
