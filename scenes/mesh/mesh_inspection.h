// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "scenes/mesh/mesh.h"

namespace sightline {

/// What `sightline target` tells of a mesh. An edge is open when only one triangle has it, and
/// sharp when its two faces turn by `kSharpAngleDeg` or more.
struct MeshInspection {
  Bounds bounds;
  double radius_m = 0;  ///< about the frame's origin
  int vertices = 0;
  int triangles = 0;
  int components = 0;         ///< pieces joined by shared edges
  int closed_components = 0;  ///< pieces without open edges
  int open_edges = 0;
  int non_manifold_edges = 0;  ///< shared by three triangles or more
  int flipped_edges = 0;       ///< whose two triangles disagree about outside
  int inward_components = 0;   ///< closed pieces of negative volume
  int sharp_edges = 0;
  double sharp_length_m = 0;
  double volume_m3 = 0;  ///< of the closed pieces, each counted whole where they overlap
  struct PartSummary {
    std::string name;
    int triangles = 0;
    double area_m2 = 0;
    double albedo = 0;
  };
  std::vector<PartSummary> parts;
};

constexpr double kSharpAngleDeg = 40;

MeshInspection inspect(const Mesh& mesh);

}  // namespace sightline
