// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/benchmarks/visp_model.h"

#include <cmath>

#include "pose/angles.h"

namespace sightline {
namespace {

bool is_facing(const Mesh& mesh, const Triangle& triangle, const Eigen::Vector3d& eye_m) {
  const Eigen::Vector3d& on_it_m = mesh.vertices[static_cast<size_t>(triangle.vertex[0])];
  return face_normal(mesh, triangle).dot(eye_m - on_it_m) > 0;
}

// Whether two triangles meet in a crease or in the contour.
bool is_line(const Mesh& mesh, int first, int second, const Eigen::Vector3d& eye_m) {
  constexpr double kCreaseRad = 20 * kDegree;
  const Triangle& a = mesh.triangles[static_cast<size_t>(first)];
  const Triangle& b = mesh.triangles[static_cast<size_t>(second)];
  return face_normal(mesh, a).dot(face_normal(mesh, b)) < std::cos(kCreaseRad) ||
         is_facing(mesh, a, eye_m) != is_facing(mesh, b, eye_m);
}

}  // namespace

VispModel visp_model(const Mesh& mesh, const Eigen::Vector3d& eye_m) {
  VispModel model;
  model.vertices_m = mesh.vertices;
  for (const Triangle& triangle : mesh.triangles) model.triangles.push_back(triangle.vertex);
  const std::vector<HalfEdge> sides = sorted_half_edges(mesh);
  for (size_t i = 0; i < sides.size(); ++i) {
    const bool is_shared = i + 1 < sides.size() && sides[i + 1].low == sides[i].low &&
                           sides[i + 1].high == sides[i].high;
    if (!is_shared || is_line(mesh, sides[i].triangle, sides[i + 1].triangle, eye_m)) {
      model.lines.push_back({sides[i].low, sides[i].high});
    }
    if (is_shared) ++i;
  }
  return model;
}

}  // namespace sightline
