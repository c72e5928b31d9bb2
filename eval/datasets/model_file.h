// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

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

}  // namespace sightline
