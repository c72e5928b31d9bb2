// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include <Eigen/Core>

#include "scenes/mesh/mesh.h"

namespace sightline {

inline void add_triangle(Mesh& mesh, int a, int b, int c) {
  Triangle triangle;
  triangle.vertex = {a, b, c};
  triangle.normal.fill(face_normal(mesh, triangle));
  mesh.triangles.push_back(triangle);
}

/// A prism along z over a polygon (counter-clockwise from above, star-shaped about its first
/// vertex), flat.
inline Mesh prism(const std::vector<Eigen::Vector2d>& outline) {
  const int n = static_cast<int>(outline.size());
  Mesh mesh;
  mesh.parts = {{"prism", 0.8}};
  for (const double z : {0.0, 1.0}) {
    for (const Eigen::Vector2d& p : outline) mesh.vertices.emplace_back(p.x(), p.y(), z);
  }
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    add_triangle(mesh, i, next, n + next);
    add_triangle(mesh, i, n + next, n + i);
    if (i == 0 || next == 0) continue;
    add_triangle(mesh, 0, next, i);
    add_triangle(mesh, n, n + i, n + next);
  }
  return mesh;
}

}  // namespace sightline
