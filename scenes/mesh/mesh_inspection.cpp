// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/mesh_inspection.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include <Eigen/Geometry>

#include "scenes/mesh/disjoint_sets.h"

namespace sightline {
namespace {

double signed_volume(const Mesh& mesh, const Triangle& triangle) {
  const auto& v = triangle.vertex;
  return mesh.vertices[v[0]].dot(mesh.vertices[v[1]].cross(mesh.vertices[v[2]])) / 6;
}

// Calls with the sides between each two vertices, which lie beside each other.
template <typename Visit>
void for_each_edge(std::span<const HalfEdge> halves, const Visit& visit) {
  for (size_t i = 0; i < halves.size();) {
    size_t next = i + 1;
    while (next < halves.size() && halves[next].low == halves[i].low &&
           halves[next].high == halves[i].high) {
      ++next;
    }
    visit(halves.subspan(i, next - i));
    i = next;
  }
}

void count_edges(const Mesh& mesh, std::span<const HalfEdge> halves, MeshInspection& out) {
  const double cos_sharp = std::cos(kSharpAngleDeg * std::numbers::pi / 180);
  for_each_edge(halves, [&](std::span<const HalfEdge> uses) {
    if (uses.size() == 1) ++out.open_edges;
    if (uses.size() > 2) ++out.non_manifold_edges;
    if (uses.size() != 2) return;
    const bool is_flipped = uses[0].is_forward == uses[1].is_forward;
    if (is_flipped) ++out.flipped_edges;
    const double cos_turn = face_normal(mesh, mesh.triangles[uses[0].triangle])
                                .dot(face_normal(mesh, mesh.triangles[uses[1].triangle]));
    if ((is_flipped ? -cos_turn : cos_turn) > cos_sharp) return;
    ++out.sharp_edges;
    out.sharp_length_m += (mesh.vertices[uses[0].low] - mesh.vertices[uses[0].high]).norm();
  });
}

void count_components(const Mesh& mesh, std::span<const HalfEdge> halves, MeshInspection& out) {
  DisjointSets components(mesh.triangles.size());
  for_each_edge(halves, [&](std::span<const HalfEdge> uses) {
    for (const HalfEdge& use : uses) components.join(use.triangle, uses.front().triangle);
  });
  // Of the triangle that stands for its component.
  std::vector<double> volume_m3(mesh.triangles.size(), 0);
  std::vector<bool> is_open(mesh.triangles.size(), false);
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    volume_m3[components.root(static_cast<int>(t))] += signed_volume(mesh, mesh.triangles[t]);
  }
  for_each_edge(halves, [&](std::span<const HalfEdge> uses) {
    if (uses.size() == 1) is_open[components.root(uses[0].triangle)] = true;
  });
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (components.root(static_cast<int>(t)) != static_cast<int>(t)) continue;
    ++out.components;
    if (is_open[t]) continue;
    ++out.closed_components;
    if (volume_m3[t] < 0) ++out.inward_components;
    out.volume_m3 += volume_m3[t];
  }
}

}  // namespace

MeshInspection inspect(const Mesh& mesh) {
  MeshInspection out;
  out.bounds = bounds(mesh);
  out.radius_m = radius_m(mesh);
  out.vertices = static_cast<int>(mesh.vertices.size());
  out.triangles = static_cast<int>(mesh.triangles.size());
  const std::vector<HalfEdge> halves = sorted_half_edges(mesh);
  count_edges(mesh, halves, out);
  count_components(mesh, halves, out);
  for (const Part& part : mesh.parts) out.parts.push_back({part.name, 0, 0, part.albedo});
  for (const Triangle& triangle : mesh.triangles) {
    MeshInspection::PartSummary& part = out.parts[triangle.part];
    ++part.triangles;
    const Eigen::Vector3d& a = mesh.vertices[triangle.vertex[0]];
    part.area_m2 += (mesh.vertices[triangle.vertex[1]] - a)
                        .cross(mesh.vertices[triangle.vertex[2]] - a)
                        .norm() /
                    2;
  }
  return out;
}

}  // namespace sightline
