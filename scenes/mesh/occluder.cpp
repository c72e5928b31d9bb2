// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/occluder.h"

#include <array>
#include <cmath>
#include <mutex>
#include <vector>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

namespace sightline {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using CgalTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Kernel::Point_3 to_cgal(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

// The mesh's shape, and the tree over it once somebody has asked: pictures of a mesh without
// features never do, and of millions of triangles the tree is the largest thing there is.
struct Occluder::Tree {
  explicit Tree(const Mesh& mesh) : vertices(mesh.vertices) {
    corners.reserve(mesh.triangles.size());
    for (const Triangle& triangle : mesh.triangles) corners.push_back(triangle.vertex);
  }

  const CgalTree& built() {
    std::call_once(is_built, [this] { build(); });
    return tree;
  }

  void build() {
    for (const auto& [a, b, c] : corners) {
      const Kernel::Triangle_3 triangle(to_cgal(vertices[a]), to_cgal(vertices[b]),
                                        to_cgal(vertices[c]));
      if (!triangle.is_degenerate()) triangles.push_back(triangle);
    }
    vertices = {};
    corners = {};
    tree.insert(triangles.begin(), triangles.end());
    tree.build();
  }

  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> corners;
  std::once_flag is_built;
  Triangles triangles;
  CgalTree tree;
};

Occluder::Occluder(const Mesh& mesh) : tree_(std::make_shared<Tree>(mesh)) {}

bool Occluder::hides(const Eigen::Vector3d& point_m, const Eigen::Vector3d& eye_m,
                     double clearance_m) const {
  const Eigen::Vector3d to_eye = eye_m - point_m;
  const double distance_m = to_eye.norm();
  if (distance_m <= clearance_m) return false;
  const Eigen::Vector3d stop = point_m + to_eye * (clearance_m / distance_m);
  return tree_->built().do_intersect(Kernel::Segment_3(to_cgal(eye_m), to_cgal(stop)));
}

double Occluder::distance_m(const Eigen::Vector3d& point_m) const {
  return std::sqrt(tree_->built().squared_distance(to_cgal(point_m)));
}

}  // namespace sightline
