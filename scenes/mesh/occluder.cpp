// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/occluder.h"

#include <cmath>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

namespace sightline {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;

Kernel::Point_3 to_cgal(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

struct Occluder::Tree {
  explicit Tree(Triangles list) : triangles(std::move(list)) {
    tree.insert(triangles.begin(), triangles.end());
    tree.build();
  }

  Triangles triangles;
  CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree;
};

Occluder::Occluder(const Mesh& mesh) {
  Triangles triangles;
  for (const Triangle& triangle : mesh.triangles) {
    const Kernel::Triangle_3 corners(to_cgal(mesh.vertices[triangle.vertex[0]]),
                                     to_cgal(mesh.vertices[triangle.vertex[1]]),
                                     to_cgal(mesh.vertices[triangle.vertex[2]]));
    if (!corners.is_degenerate()) triangles.push_back(corners);
  }
  tree_ = std::make_shared<const Tree>(std::move(triangles));
}

bool Occluder::hides(const Eigen::Vector3d& point_m, const Eigen::Vector3d& eye_m,
                     double clearance_m) const {
  const Eigen::Vector3d to_eye = eye_m - point_m;
  const double distance_m = to_eye.norm();
  if (distance_m <= clearance_m) return false;
  const Eigen::Vector3d stop = point_m + to_eye * (clearance_m / distance_m);
  return tree_->tree.do_intersect(Kernel::Segment_3(to_cgal(eye_m), to_cgal(stop)));
}

double Occluder::distance_m(const Eigen::Vector3d& point_m) const {
  return std::sqrt(tree_->tree.squared_distance(to_cgal(point_m)));
}

}  // namespace sightline
