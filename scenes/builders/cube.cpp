// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/builders/cube.h"

#include <array>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace sightline {
namespace {

struct CubeFace {
  const char* name;
  double albedo;
  std::array<int, 4> corners;  // counter-clockwise from outside
};

// Six shades, opposite faces nearest to each other because no view shows both.
constexpr std::array<CubeFace, 6> kFaces = {{
    {"front", 0.70, {1, 3, 7, 5}},
    {"back", 0.74, {0, 4, 6, 2}},
    {"starboard", 0.79, {2, 6, 7, 3}},
    {"port", 0.84, {0, 1, 5, 4}},
    {"bottom", 0.90, {4, 5, 7, 6}},
    {"top", 0.95, {0, 2, 3, 1}},
}};

Eigen::Vector3d corner(int index, double edge_m) {
  const auto side = [&](int bit) { return (index >> bit & 1) != 0 ? edge_m / 2 : -edge_m / 2; };
  return {side(0), side(1), side(2)};
}

}  // namespace

BuiltTarget build_cube(double edge_m) {
  BuiltTarget cube{
      "cube", fmt::format("Cube of {} m, each face its own shade", edge_m), Mesh{}, {}};
  for (int i = 0; i < 8; ++i) cube.mesh.vertices.push_back(corner(i, edge_m));
  for (const CubeFace& face : kFaces) {
    const int part = static_cast<int>(cube.mesh.parts.size());
    cube.mesh.parts.push_back({face.name, face.albedo});
    const auto& [a, b, c, d] = face.corners;
    const Eigen::Vector3d along = cube.mesh.vertices[b] - cube.mesh.vertices[a];
    const Eigen::Vector3d normal =
        along.cross(cube.mesh.vertices[d] - cube.mesh.vertices[a]).normalized();
    cube.mesh.triangles.push_back({{a, b, c}, part, {normal, normal, normal}});
    cube.mesh.triangles.push_back({{a, c, d}, part, {normal, normal, normal}});
  }
  for (int i = 0; i < 8; ++i) {
    cube.features.push_back(line_intersection(
        fmt::format("vertex_{}", i), corner(i, edge_m),
        std::array{corner(i ^ 1, edge_m), corner(i ^ 2, edge_m), corner(i ^ 4, edge_m)}));
  }
  return cube;
}

}  // namespace sightline
