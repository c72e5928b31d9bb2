// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/occluder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
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
    const std::vector<bool> one_sided = one_sided_parts(mesh);
    if (one_sided.empty()) return;
    for (const Triangle& triangle : mesh.triangles) {
      is_one_sided.push_back(one_sided[triangle.part]);
    }
  }

  const CgalTree& built() {
    std::call_once(is_built, [this] { build(); });
    return tree;
  }

  // Whether a triangle is there for an eye; asked where some have one side.
  bool is_there(Triangles::const_iterator triangle, const Kernel::Point_3& eye) const {
    if (!is_one_sided[static_cast<size_t>(triangle - triangles.begin())]) return true;
    return !triangle->supporting_plane().has_on_negative_side(eye);
  }

  void build() {
    size_t kept = 0;
    for (size_t i = 0; i < corners.size(); ++i) {
      const auto [a, b, c] = corners[i];
      const Kernel::Triangle_3 triangle(to_cgal(vertices[a]), to_cgal(vertices[b]),
                                        to_cgal(vertices[c]));
      if (triangle.is_degenerate()) continue;
      triangles.push_back(triangle);
      if (!is_one_sided.empty()) is_one_sided[kept++] = is_one_sided[i];
    }
    vertices = {};
    corners = {};
    tree.insert(triangles.begin(), triangles.end());
    tree.build();
  }

  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> corners;
  std::vector<bool> is_one_sided;  // of the corners', later of the triangles; empty: none is
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
  const Kernel::Segment_3 from_eye(to_cgal(eye_m), to_cgal(stop));
  const CgalTree& tree = tree_->built();
  if (!tree.do_intersect(from_eye)) return false;
  if (tree_->is_one_sided.empty()) return true;
  std::vector<CgalTree::Primitive_id> met;
  tree.all_intersected_primitives(from_eye, std::back_inserter(met));
  return std::any_of(met.begin(), met.end(), [&](const auto& triangle) {
    return tree_->is_there(triangle, from_eye.source());
  });
}

bool Occluder::hides_own(const Eigen::Vector3d& point_m, const Eigen::Vector3d& eye_m,
                         double clearance_m) const {
  if (hides(point_m, eye_m, clearance_m)) return true;
  if (tree_->is_one_sided.empty()) return false;
  const CgalTree& tree = tree_->built();
  if (tree.empty()) return false;
  constexpr double kRounding = 1e-9;  // of the coordinates: triangles that meet at the point
  const double rounding_m = kRounding * (point_m.cwiseAbs().maxCoeff() + distance_m(point_m));
  const double reach_m = std::max(clearance_m, distance_m(point_m) + rounding_m);
  const Eigen::Vector3d low = point_m.array() - reach_m;
  const Eigen::Vector3d high = point_m.array() + reach_m;
  std::vector<CgalTree::Primitive_id> near;
  tree.all_intersected_primitives(
      CGAL::Bbox_3(low.x(), low.y(), low.z(), high.x(), high.y(), high.z()),
      std::back_inserter(near));
  return std::none_of(near.begin(), near.end(), [&](const auto& triangle) {
    return CGAL::squared_distance(to_cgal(point_m), *triangle) <= reach_m * reach_m &&
           tree_->is_there(triangle, to_cgal(eye_m));
  });
}

double Occluder::distance_m(const Eigen::Vector3d& point_m) const {
  return std::sqrt(tree_->built().squared_distance(to_cgal(point_m)));
}

}  // namespace sightline
