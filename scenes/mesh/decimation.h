// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "scenes/mesh/mesh.h"

namespace sightline {

/// A mesh with about this fraction (over 0, up to 1) of the triangles: edges are collapsed, the
/// cheapest first (Lindstrom and Turk, Fast and memory efficient polygonal simplification, 1998, by
/// CGAL). Every triangle left keeps its part; normals are computed anew with a crease angle of 55
/// degrees. The mesh may be an open, non-manifold soup, which is torn where more than two triangles
/// meet at an edge.
Mesh decimated(const Mesh& mesh, double kept_fraction);

}  // namespace sightline
