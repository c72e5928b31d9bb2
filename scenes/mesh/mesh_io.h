// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "scenes/mesh/mesh.h"

namespace sightline {

/// How a mesh file's axes and unit relate to the target's frame (x forward, y starboard, z down).
/// Axes are named "+x" (or "x"), "-x", ... "-z"; the default leaves coordinates as they are.
struct MeshFrame {
  std::string forward = "+x";  ///< the file's axis that points forward
  std::string up = "-z";       ///< the file's axis that points up
  double unit_m = 1;           ///< metres in one unit of the file, 1e-6 to 1e6
};

/// Metres in a unit: "m", "cm", "mm", "km", "in", "ft", or a number such as "0.0254". Throws
/// InputError for anything else.
double unit_named(const std::string& unit);

/// What cleaning a mesh took away.
struct CleaningSummary {
  int welded_vertices = 0;
  int degenerate_triangles = 0;
  int duplicate_triangles = 0;
};

struct LoadedMesh {
  Mesh mesh;
  CleaningSummary cleaning;
  /// Turns the file's axes into the target's; the unit is not in it.
  Eigen::Matrix3d target_from_file = Eigen::Matrix3d::Identity();
};

/// Reads a mesh: .glb and .gltf through tinygltf, all else through Assimp, in a child process with
/// limits on memory and time (see `read_in_child` in scenes/mesh_soup.h for what that asks of the
/// caller). Coincident vertices are welded (within 1e-6 of the size), degenerate and duplicate
/// triangles dropped; a triangle given once for each side is a duplicate, since both sides are
/// drawn. Normals of the file are kept, turned to the side where their triangle is
/// counter-clockwise; where it has none they are those of the triangles in glTF, and computed with
/// a crease angle of 45 degrees in other formats. Each
/// mesh (in glTF, each primitive) of each node is a part; its albedo is the luminance of the
/// material's base or diffuse colour. Throws InputError for a missing, unreadable, empty, too large
/// (1 GiB, 12 000 000 triangles, 65 535 parts) or non-finite mesh, one that its reader crashes on,
/// and a wrong MeshFrame.
LoadedMesh read_mesh(const std::filesystem::path& file, const MeshFrame& frame = {});

/// Writes a .glb with tinygltf, one node and material a part that has triangles, in glTF's own
/// frame (y up, z forward): read it back with MeshFrame{"+z", "+y", 1}. Of a material its factors
/// are written, its sides, and the textures of its base colour, opaque, and of its occlusion,
/// within the file; what else it has of textures, an occlusion that lies otherwise than the colour,
/// and the corners' colours are lost. A part without a material is there from both sides. Where it
/// has a texture, all the mesh's pictures are in the file. The same mesh gives the same bytes.
/// Throws InputError when the file cannot be written.
void write_glb(const Mesh& mesh, const std::filesystem::path& file);

}  // namespace sightline
