// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <tuple>

#include <Eigen/Geometry>

namespace sightline {
namespace {

// Twice the area times the unit normal.
Eigen::Vector3d area_vector(const Mesh& mesh, const Triangle& triangle) {
  const Eigen::Vector3d& a = mesh.vertices[triangle.vertex[0]];
  return (mesh.vertices[triangle.vertex[1]] - a).cross(mesh.vertices[triangle.vertex[2]] - a);
}

// The triangles around each vertex, in their order: one list in which each vertex has a stretch.
class FacesAt {
 public:
  explicit FacesAt(const Mesh& mesh)
      : begin_(mesh.vertices.size() + 2, 0), faces_(3 * mesh.triangles.size()) {
    for (const Triangle& triangle : mesh.triangles) {
      for (const int v : triangle.vertex) ++begin_[v + 2];
    }
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
      for (const int v : mesh.triangles[i].vertex) faces_[begin_[v + 1]++] = static_cast<int>(i);
    }
  }

  std::span<const int> vertex(int v) const {
    return std::span(faces_).subspan(begin_[v], begin_[v + 1] - begin_[v]);
  }

 private:
  std::vector<size_t> begin_;
  std::vector<int> faces_;
};

}  // namespace

Eigen::Vector3d face_normal(const Mesh& mesh, const Triangle& triangle) {
  const Eigen::Vector3d area = area_vector(mesh, triangle);
  const double length = area.norm();
  return length > 0 ? Eigen::Vector3d(area / length) : Eigen::Vector3d::Zero();
}

void compute_corner_normals(Mesh& mesh, double crease_angle_rad) {
  for (Triangle& triangle : mesh.triangles) {
    for (Eigen::Vector3d& normal : triangle.normal) normal.setZero();
  }
  add_missing_normals(mesh, crease_angle_rad);
}

void add_missing_normals(Mesh& mesh, double crease_angle_rad) {
  const auto lacks_normals = [](const Triangle& triangle) {
    return std::ranges::any_of(triangle.normal, [](const auto& n) { return n.isZero(0); });
  };
  if (std::ranges::none_of(mesh.triangles, lacks_normals)) return;
  std::vector<Eigen::Vector3d> area;
  area.reserve(mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) area.push_back(area_vector(mesh, triangle));
  const FacesAt faces_at(mesh);
  const double cos_crease = std::cos(crease_angle_rad);
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3d own = area[i].normalized();
    for (int corner = 0; corner < 3; ++corner) {
      if (!mesh.triangles[i].normal[corner].isZero(0)) continue;
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const int face : faces_at.vertex(mesh.triangles[i].vertex[corner])) {
        if (area[face].dot(own) >= cos_crease * area[face].norm()) sum += area[face];
      }
      mesh.triangles[i].normal[corner] = sum.norm() > 0 ? sum.normalized() : own;
    }
  }
}

std::vector<HalfEdge> sorted_half_edges(const Mesh& mesh) {
  // Sides that begin at the same low vertex are few: they get their places by counting, and are
  // sorted among themselves.
  const auto for_each_side = [&](const auto& visit) {
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int i = 0; i < 3; ++i) {
        const int from = mesh.triangles[t].vertex[i];
        const int to = mesh.triangles[t].vertex[(i + 1) % 3];
        visit(HalfEdge{std::min(from, to), std::max(from, to), static_cast<int>(t), from < to});
      }
    }
  };
  std::vector<size_t> begin(mesh.vertices.size() + 2, 0);
  for_each_side([&](const HalfEdge& half) { ++begin[half.low + 2]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<HalfEdge> halves(3 * mesh.triangles.size());
  for_each_side([&](const HalfEdge& half) { halves[begin[half.low + 1]++] = half; });
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    const auto place = [&](size_t i) { return halves.begin() + static_cast<std::ptrdiff_t>(i); };
    std::sort(place(begin[v]), place(begin[v + 1]), [](const HalfEdge& a, const HalfEdge& b) {
      return std::tie(a.high, a.triangle) < std::tie(b.high, b.triangle);
    });
  }
  return halves;
}

std::vector<bool> one_sided_parts(const Mesh& mesh) {
  const auto is_one_sided = [](const Part& part) {
    return part.material && !part.material->is_two_sided;
  };
  if (std::none_of(mesh.parts.begin(), mesh.parts.end(), is_one_sided)) return {};
  std::vector<bool> one_sided(mesh.parts.size());
  std::transform(mesh.parts.begin(), mesh.parts.end(), one_sided.begin(), is_one_sided);
  return one_sided;
}

bool is_seen_from_behind(const Mesh& mesh, const Triangle& triangle, const Eigen::Vector3d& eye_m) {
  const Eigen::Vector3d a = mesh.vertices[triangle.vertex[0]] - eye_m;
  const Eigen::Vector3d b = mesh.vertices[triangle.vertex[1]] - eye_m;
  const Eigen::Vector3d c = mesh.vertices[triangle.vertex[2]] - eye_m;
  return (b - a).cross(c - a).dot(a) > 0;
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
