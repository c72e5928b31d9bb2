// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/target/facets.h"

#include <algorithm>

#include "scenes/mesh/disjoint_sets.h"

namespace sightline {
namespace {

constexpr size_t kMostTriangles = 20000;  // hardly that many in a hundred facets
constexpr size_t kMostFacets = 100;
constexpr double kFlatCosine = 1 - 1e-9;
constexpr double kEvenCosine = 1 - 1e-6;

bool is_even(const Triangle& triangle, const Eigen::Vector3d& normal) {
  return std::all_of(triangle.normal.begin(), triangle.normal.end(),
                     [&](const auto& corner) { return corner.dot(normal) >= kEvenCosine; });
}

// Two triangles to every side, which wind alike.
bool is_closed(const std::vector<HalfEdge>& halves) {
  if (halves.size() % 2 != 0) return false;
  for (size_t i = 0; i < halves.size(); i += 2) {
    const HalfEdge& a = halves[i];
    const HalfEdge& b = halves[i + 1];
    if (a.low != b.low || a.high != b.high || a.is_forward == b.is_forward) return false;
    if (i == 0) continue;
    const HalfEdge& before = halves[i - 1];
    if (before.low == a.low && before.high == a.high) return false;
  }
  return true;
}

bool is_convex(const Facets& facets) {
  constexpr double kRounding = 1e-9;  // of the size
  double size_m = 0;
  for (const FacetEdge& edge : facets.edges) {
    size_m = std::max(size_m, (edge.begin_m - facets.facets.front().point_m).norm());
  }
  return std::all_of(facets.facets.begin(), facets.facets.end(), [&](const Facet& facet) {
    return std::all_of(facets.edges.begin(), facets.edges.end(), [&](const FacetEdge& edge) {
      return facet.normal.dot(edge.begin_m - facet.point_m) <= kRounding * size_m;
    });
  });
}

}  // namespace

Facets facets_of(const Mesh& mesh) {
  if (mesh.triangles.empty() || mesh.triangles.size() > kMostTriangles) return {};
  const std::vector<HalfEdge> halves = sorted_half_edges(mesh);
  if (!is_closed(halves)) return {};
  std::vector<Eigen::Vector3d> normals;
  for (const Triangle& triangle : mesh.triangles) normals.push_back(face_normal(mesh, triangle));

  DisjointSets groups(mesh.triangles.size());
  for (size_t i = 0; i < halves.size(); i += 2) {
    const int a = halves[i].triangle;
    const int b = halves[i + 1].triangle;
    const bool is_same_part = mesh.triangles[a].part == mesh.triangles[b].part;
    if (is_same_part && normals[a].dot(normals[b]) >= kFlatCosine) groups.join(a, b);
  }
  Facets out;
  std::vector<int> facet_of(mesh.triangles.size(), -1);  // of a group's representative
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    int& facet = facet_of[groups.root(static_cast<int>(t))];
    if (facet < 0) {
      if (out.facets.size() == kMostFacets) return {};
      facet = static_cast<int>(out.facets.size());
      out.facets.push_back({mesh.vertices[mesh.triangles[t].vertex[0]], normals[t]});
    }
    Facet& own = out.facets[facet];
    own.is_even = own.is_even && is_even(mesh.triangles[t], normals[t]);
  }
  for (size_t i = 0; i < halves.size(); i += 2) {
    const HalfEdge& forward = halves[i].is_forward ? halves[i] : halves[i + 1];
    const HalfEdge& backward = halves[i].is_forward ? halves[i + 1] : halves[i];
    const int left = facet_of[groups.root(forward.triangle)];
    const int right = facet_of[groups.root(backward.triangle)];
    if (left == right) continue;
    out.edges.push_back({mesh.vertices[forward.low], mesh.vertices[forward.high], {left, right}});
  }
  out.is_convex = is_convex(out);
  return out;
}

}  // namespace sightline
