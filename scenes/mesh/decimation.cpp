// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/decimation.h"

#include <array>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_ratio_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

namespace sightline {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

constexpr double kCreaseRad = 55 * std::numbers::pi / 180;

// The mesh as CGAL has it, every face with its part.
struct PartedSurface {
  Surface surface;
  Surface::Property_map<Surface::Face_index, int> part;
};

PartedSurface surface_of(const Mesh& mesh) {
  namespace PMP = CGAL::Polygon_mesh_processing;
  std::vector<Kernel::Point_3> points;
  for (const Eigen::Vector3d& v : mesh.vertices) points.emplace_back(v.x(), v.y(), v.z());
  std::vector<std::array<size_t, 3>> triangles;
  for (const Triangle& triangle : mesh.triangles) {
    const auto& [a, b, c] = triangle.vertex;
    triangles.push_back({static_cast<size_t>(a), static_cast<size_t>(b), static_cast<size_t>(c)});
  }
  PMP::orient_polygon_soup(points, triangles);  // doubles vertices where the soup is no surface
  PartedSurface out;
  PMP::polygon_soup_to_polygon_mesh(points, triangles, out.surface);
  out.part = out.surface.add_property_map<Surface::Face_index, int>("f:part", 0).first;
  size_t triangle = 0;
  for (const Surface::Face_index face : out.surface.faces()) {
    out.part[face] = mesh.triangles[triangle++].part;
  }
  return out;
}

Mesh mesh_of(const PartedSurface& from, std::vector<Part> parts) {
  Mesh mesh;
  mesh.parts = std::move(parts);
  std::map<Surface::Vertex_index, int> index_of;
  for (const Surface::Vertex_index vertex : from.surface.vertices()) {
    const Kernel::Point_3& p = from.surface.point(vertex);
    index_of[vertex] = static_cast<int>(mesh.vertices.size());
    mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const Surface::Face_index face : from.surface.faces()) {
    Triangle triangle;
    triangle.part = from.part[face];
    int corner = 0;
    for (const auto vertex : from.surface.vertices_around_face(from.surface.halfedge(face))) {
      triangle.vertex[corner++] = index_of.at(vertex);
    }
    if (!face_normal(mesh, triangle).isZero()) mesh.triangles.push_back(triangle);
  }
  compute_corner_normals(mesh, kCreaseRad);
  return mesh;
}

}  // namespace

Mesh decimated(const Mesh& mesh, double kept_fraction) {
  namespace SMS = CGAL::Surface_mesh_simplification;
  PartedSurface parted = surface_of(mesh);
  SMS::edge_collapse(parted.surface, SMS::Count_ratio_stop_predicate<Surface>(kept_fraction));
  parted.surface.collect_garbage();
  return mesh_of(parted, mesh.parts);
}

}  // namespace sightline
