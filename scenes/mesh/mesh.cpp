// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/mesh.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <Eigen/Geometry>

namespace sightline {
namespace {

// Twice the area times the unit normal.
Eigen::Vector3d area_vector(const Mesh& mesh, const Triangle& triangle) {
  const Eigen::Vector3d& a = mesh.vertices[triangle.vertex[0]];
  return (mesh.vertices[triangle.vertex[1]] - a).cross(mesh.vertices[triangle.vertex[2]] - a);
}

}  // namespace

Eigen::Vector3d face_normal(const Mesh& mesh, const Triangle& triangle) {
  const Eigen::Vector3d area = area_vector(mesh, triangle);
  const double length = area.norm();
  return length > 0 ? Eigen::Vector3d(area / length) : Eigen::Vector3d::Zero();
}

void compute_corner_normals(Mesh& mesh, double crease_angle_rad) {
  std::vector<Eigen::Vector3d> area(mesh.triangles.size());
  std::vector<std::vector<int>> faces_at(mesh.vertices.size());
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    area[i] = area_vector(mesh, mesh.triangles[i]);
    for (const int v : mesh.triangles[i].vertex) faces_at[v].push_back(static_cast<int>(i));
  }
  const double cos_crease = std::cos(crease_angle_rad);
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3d own = area[i].normalized();
    for (int corner = 0; corner < 3; ++corner) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const int face : faces_at[mesh.triangles[i].vertex[corner]]) {
        if (area[face].dot(own) >= cos_crease * area[face].norm()) sum += area[face];
      }
      mesh.triangles[i].normal[corner] = sum.norm() > 0 ? sum.normalized() : own;
    }
  }
}

std::vector<HalfEdge> sorted_half_edges(const Mesh& mesh) {
  std::vector<HalfEdge> halves;
  halves.reserve(3 * mesh.triangles.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const int from = mesh.triangles[t].vertex[i];
      const int to = mesh.triangles[t].vertex[(i + 1) % 3];
      halves.push_back({std::min(from, to), std::max(from, to), static_cast<int>(t), from < to});
    }
  }
  std::sort(halves.begin(), halves.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return halves;
}

Bounds bounds(const Mesh& mesh) {
  Bounds box{mesh.vertices.front(), mesh.vertices.front()};
  for (const Eigen::Vector3d& v : mesh.vertices) {
    box.min_m = box.min_m.cwiseMin(v);
    box.max_m = box.max_m.cwiseMax(v);
  }
  return box;
}

Eigen::Vector3d middle_m(const Mesh& mesh) {
  const Bounds box = bounds(mesh);
  return (box.min_m + box.max_m) / 2;
}

double radius_m(const Mesh& mesh, const Eigen::Vector3d& about_m) {
  double radius = 0;
  for (const Eigen::Vector3d& v : mesh.vertices) radius = std::max(radius, (v - about_m).norm());
  return radius;
}

}  // namespace sightline
