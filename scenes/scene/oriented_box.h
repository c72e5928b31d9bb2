// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The box of a body that stands before the camera, by which bodies are kept apart.
#pragma once

#include <Eigen/Core>

#include "pose/pose.h"
#include "scenes/mesh/mesh.h"

namespace sightline {

/// A box that is turned: its middle, and from there to the middles of three of its faces.
struct OrientedBox {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  Eigen::Matrix3d half_axes = Eigen::Matrix3d::Zero();  ///< a column each, across each other
};

/// The box along the mesh's own axes that just holds it, where the pose puts it. The mesh must have
/// vertices.
OrientedBox oriented_box(const Mesh& mesh, const Pose& cam_from_mesh);

/// Whether two boxes have a point in common. By the separating axis theorem (S. Gottschalk et al.,
/// OBBTree, 1996): they have none where their shadows on the normal of a face, or on a line across
/// an edge of each, are apart. Boxes that touch to rounding may count as either.
bool do_overlap(const OrientedBox& a, const OrientedBox& b);

}  // namespace sightline
