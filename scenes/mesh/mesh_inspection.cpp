// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/mesh_inspection.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Geometry>

#include "scenes/mesh/disjoint_sets.h"

namespace sightline {
namespace {

struct EdgeUse {
  int triangle;
  bool is_forward;  // runs from the smaller vertex index to the larger
};

using EdgeMap = std::map<std::pair<int, int>, std::vector<EdgeUse>>;

EdgeMap edges_of(const Mesh& mesh) {
  EdgeMap edges;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t].vertex;
    for (int i = 0; i < 3; ++i) {
      const int a = v[i];
      const int b = v[(i + 1) % 3];
      edges[{std::min(a, b), std::max(a, b)}].push_back({static_cast<int>(t), a < b});
    }
  }
  return edges;
}

struct ComponentSummary {
  bool is_closed = true;
  double volume_m3 = 0;
};

double signed_volume(const Mesh& mesh, const Triangle& triangle) {
  const auto& v = triangle.vertex;
  return mesh.vertices[v[0]].dot(mesh.vertices[v[1]].cross(mesh.vertices[v[2]])) / 6;
}

void count_edges(const Mesh& mesh, const EdgeMap& edges, MeshInspection& out) {
  const double cos_sharp = std::cos(kSharpAngleDeg * std::numbers::pi / 180);
  for (const auto& [ends, uses] : edges) {
    if (uses.size() == 1) ++out.open_edges;
    if (uses.size() > 2) ++out.non_manifold_edges;
    if (uses.size() != 2) continue;
    const bool is_flipped = uses[0].is_forward == uses[1].is_forward;
    if (is_flipped) ++out.flipped_edges;
    const double cos_turn = face_normal(mesh, mesh.triangles[uses[0].triangle])
                                .dot(face_normal(mesh, mesh.triangles[uses[1].triangle]));
    if ((is_flipped ? -cos_turn : cos_turn) > cos_sharp) continue;
    ++out.sharp_edges;
    out.sharp_length_m += (mesh.vertices[ends.first] - mesh.vertices[ends.second]).norm();
  }
}

void count_components(const Mesh& mesh, const EdgeMap& edges, MeshInspection& out) {
  DisjointSets components(mesh.triangles.size());
  for (const auto& [ends, uses] : edges) {
    for (const EdgeUse& use : uses) components.join(use.triangle, uses.front().triangle);
  }
  std::map<int, ComponentSummary> summaries;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    summaries[components.root(static_cast<int>(t))].volume_m3 +=
        signed_volume(mesh, mesh.triangles[t]);
  }
  for (const auto& [ends, uses] : edges) {
    if (uses.size() == 1) summaries[components.root(uses[0].triangle)].is_closed = false;
  }
  out.components = static_cast<int>(summaries.size());
  for (const auto& [root, summary] : summaries) {
    if (!summary.is_closed) continue;
    ++out.closed_components;
    if (summary.volume_m3 < 0) ++out.inward_components;
    out.volume_m3 += summary.volume_m3;
  }
}

}  // namespace

MeshInspection inspect(const Mesh& mesh) {
  MeshInspection out;
  out.bounds = bounds(mesh);
  out.radius_m = radius_m(mesh);
  out.vertices = static_cast<int>(mesh.vertices.size());
  out.triangles = static_cast<int>(mesh.triangles.size());
  const EdgeMap edges = edges_of(mesh);
  count_edges(mesh, edges, out);
  count_components(mesh, edges, out);
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
