// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "scenes/mesh/mesh.h"

namespace sightline {

/// A connected, flat piece of a mesh's surface, of one part: of one shade under a distant light.
struct Facet {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< on it
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();   ///< unit, outward
  bool is_even = true;  ///< its shading normals are its own: it is no part of a rounded surface

  bool is_towards(const Eigen::Vector3d& eye_m) const { return normal.dot(eye_m - point_m) > 0; }
};

/// A stretch of the border between two facets.
struct FacetEdge {
  Eigen::Vector3d begin_m;
  Eigen::Vector3d end_m;
  std::array<int, 2> facet;  ///< on the left and on the right, looked at from outside
};

struct Facets {
  std::vector<Facet> facets;
  std::vector<FacetEdge> edges;
  bool is_convex = false;  ///< no facet hides another

  bool empty() const { return facets.empty(); }
};

/// The facets of a mesh with no more than a hundred of them; of others, and of meshes that are not
/// closed, none.
Facets facets_of(const Mesh& mesh);

}  // namespace sightline
