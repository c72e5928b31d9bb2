// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "scenes/mesh_io.h"

namespace sightline {

/// A triangle as a file gives it: its own three corners, in the file's axes and unit.
struct SoupTriangle {
  std::array<Eigen::Vector3d, 3> corner;
  std::array<Eigen::Vector3d, 3> normal;  ///< zero where the file has none
  int part = 0;
};

/// What the readers of mesh files hand to the one place that cleans meshes.
struct MeshSoup {
  std::vector<SoupTriangle> triangles;
  std::vector<Part> parts;
};

/// The two readers; `read_mesh` chooses. Both throw InputError with the library's own words.
MeshSoup read_gltf(const std::filesystem::path& file);
MeshSoup read_with_assimp(const std::filesystem::path& file);

/// Adds a triangle whose corners and normals are carried by `file_from_mesh`; a mirroring transform
/// reverses the winding so that it stays counter-clockwise from outside.
void add_transformed(MeshSoup& soup, const SoupTriangle& triangle,
                     const Eigen::Matrix4d& file_from_mesh);

/// Linear luminance of a linear RGB colour (Rec. 709 weights), clamped to [0, 1].
double luminance(double red, double green, double blue);

}  // namespace sightline
