// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include <Eigen/Core>

#include "scenes/mesh/mesh.h"

namespace sightline {

/// A mesh as binary PLY in millimetres, in its own frame: float vertices, triangles.
std::string ply_bytes(const Mesh& mesh);

/// The same with a normal and a colour (sRGB, 8 bits) a vertex: means over the corners of triangles
/// that meet there, of normals, and of base colours with the corners' own. A texture counts as the
/// texel where a corner lies. The vertices are those of ply_bytes, in their order.
std::string coloured_ply_bytes(const Mesh& mesh);

/// A vertex as that PLY has it.
Eigen::Vector3f ply_vertex_mm(const Eigen::Vector3d& vertex_m);

/// The vertices of a PLY file, in its order and unit, none welded, dropped or added, with the faces
/// as triangles. `read_mesh` (scenes/mesh/mesh_io.h), which cleans, would change the means over
/// vertices that BOP's errors are. Throws InputError for a file that cannot be read or has no
/// vertices.
Mesh read_ply_as_it_is(const std::filesystem::path& file);

}  // namespace sightline
