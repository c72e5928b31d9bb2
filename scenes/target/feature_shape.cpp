// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/target/feature_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include <Eigen/Geometry>

namespace sightline {
namespace {

constexpr double kOutlineCosine = 1 - 1e-9;  // faces that turn less make no outline
// Of a feature's edge: a vertex of the mesh this near to it (times its length) lies on it.
constexpr double kOnEdge = 1e-4;

struct SharedEdge {
  MeshEdge edge;
  std::array<int, 2> part;
};

// Every edge of the mesh at which it turns or ends; where more than two faces meet, the first two.
std::vector<SharedEdge> turning_edges(const Mesh& mesh) {
  const std::vector<HalfEdge> halves = sorted_half_edges(mesh);
  std::vector<SharedEdge> edges;
  for (size_t i = 0; i < halves.size();) {
    size_t next = i + 1;
    while (next < halves.size() && halves[next].low == halves[i].low &&
           halves[next].high == halves[i].high) {
      ++next;
    }
    const HalfEdge& first = halves[i];
    const HalfEdge& second = next > i + 1 ? halves[i + 1] : first;
    const Triangle& a = mesh.triangles[first.triangle];
    const Triangle& b = mesh.triangles[second.triangle];
    SharedEdge shared;
    shared.edge.begin_m = mesh.vertices[first.is_forward ? first.low : first.high];
    shared.edge.end_m = mesh.vertices[first.is_forward ? first.high : first.low];
    shared.edge.face_normal = {face_normal(mesh, a), face_normal(mesh, b)};
    shared.edge.is_open = next == i + 1;
    shared.part = {a.part, b.part};
    if (shared.edge.is_open || shared.edge.cos_turn() < kOutlineCosine) edges.push_back(shared);
    i = next;
  }
  return edges;
}

// `clearance_m` is that of the feature: its edges may be lines laid through bent ones.
bool is_on(const Eigen::Vector3d& point, const Edge& edge, double clearance_m) {
  const Eigen::Vector3d along = edge.end_m - edge.begin_m;
  const double length_m = along.norm();
  const double allowed_m = std::max(kOnEdge * length_m, clearance_m);
  const double at_m = (point - edge.begin_m).dot(along) / length_m;
  const double off_m = (point - edge.begin_m - at_m / length_m * along).norm();
  return off_m <= allowed_m && at_m >= -allowed_m && at_m <= length_m + allowed_m;
}

double distance_m(const Eigen::Vector3d& point, const MeshEdge& edge) {
  const Eigen::Vector3d along = edge.end_m - edge.begin_m;
  const double at = std::clamp((point - edge.begin_m).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (point - edge.begin_m - at * along).norm();
}

std::set<int> parts_named(const Mesh& mesh, const std::vector<std::string>& names) {
  std::set<int> parts;
  for (size_t i = 0; i < mesh.parts.size(); ++i) {
    if (std::find(names.begin(), names.end(), mesh.parts[i].name) != names.end()) {
      parts.insert(static_cast<int>(i));
    }
  }
  return parts;
}

double bevel_m(const Edge& own, const std::vector<MeshEdge>& edges, double clearance_m) {
  constexpr double kParallelCosine = 0.9;
  const double turn_cosine = std::cos(10 * std::numbers::pi / 180);
  const Eigen::Vector3d along = own.end_m - own.begin_m;
  double least_m = std::numeric_limits<double>::infinity();
  for (const MeshEdge& edge : edges) {
    const Eigen::Vector3d direction = (edge.end_m - edge.begin_m).normalized();
    if (std::abs(direction.dot(along)) < kParallelCosine * along.norm()) continue;
    if (edge.cos_turn() > turn_cosine || is_on(edge.begin_m, own, clearance_m) ||
        is_on(edge.end_m, own, clearance_m)) {
      continue;
    }
    for (const double t : {0.25, 0.5, 0.75}) {
      least_m = std::min(least_m, distance_m(own.begin_m + t * along, edge));
    }
  }
  return least_m;
}

FeatureShape shape_of(const TargetFeature& feature, const Mesh& mesh,
                      const std::vector<SharedEdge>& edges) {
  FeatureShape shape;
  std::set<int> parts = parts_named(mesh, feature.parts);
  if (feature.kind == FeatureKind::kLineIntersection) {
    shape.along.resize(feature.edges.size());
    for (const SharedEdge& shared : edges) {
      for (size_t i = 0; i < feature.edges.size(); ++i) {
        const Edge& own = feature.edges[i];
        if (!is_on(shared.edge.begin_m, own, feature.clearance_m) ||
            !is_on(shared.edge.end_m, own, feature.clearance_m)) {
          continue;
        }
        shape.along[i].push_back(shared.edge);
        if (feature.parts.empty()) parts.insert(shared.part.begin(), shared.part.end());
      }
    }
  }
  for (std::vector<MeshEdge>& along : shape.along) {
    std::sort(along.begin(), along.end(), [&](const MeshEdge& a, const MeshEdge& b) {
      return distance_m(feature.position_m, a) < distance_m(feature.position_m, b);
    });
  }
  double total_m = 0;
  for (const SharedEdge& shared : edges) {
    if (!parts.contains(shared.part[0]) && !parts.contains(shared.part[1])) continue;
    if (distance_m(feature.position_m, shared.edge) > feature.reach_m) continue;
    shape.edges.push_back(shared.edge);
    const double length_m = (shared.edge.end_m - shared.edge.begin_m).norm();
    shape.inside_m += length_m / 2 * (shared.edge.begin_m + shared.edge.end_m);
    total_m += length_m;
  }
  if (total_m > 0) shape.inside_m /= total_m;
  for (const Edge& own : feature.edges) {
    shape.bevel_m.push_back(bevel_m(own, shape.edges, feature.clearance_m));
  }
  return shape;
}

}  // namespace

std::string_view to_string(FeatureKind kind) {
  switch (kind) {
    case FeatureKind::kLineIntersection:
      return "line_intersection";
    case FeatureKind::kCorner:
      return "corner";
    case FeatureKind::kContour:
      return "contour";
  }
  return "unknown";
}

std::vector<FeatureShape> feature_shapes(const Mesh& mesh,
                                         const std::vector<TargetFeature>& features) {
  std::vector<FeatureShape> shapes;
  if (features.empty()) return shapes;
  const std::vector<SharedEdge> edges = turning_edges(mesh);
  for (const TargetFeature& feature : features) shapes.push_back(shape_of(feature, mesh, edges));
  return shapes;
}

}  // namespace sightline
