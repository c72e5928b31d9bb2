// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "scenes/mesh/material.h"

namespace sightline {

/// A painted or separate piece of a target. A triangle's part id in a frame is its index plus one.
struct Part {
  std::string name;
  double albedo = 0.8;  ///< linear reflectance, 0 to 1: in colour, the luminance of the factor
  std::optional<Material> material = {};  ///< none: grey and dull
};

struct Triangle {
  std::array<int, 3> vertex{};  ///< indices into Mesh::vertices, counter-clockwise from outside
  int part = 0;                 ///< index into Mesh::parts
  /// Unit shading normals at the three corners, outward.
  std::array<Eigen::Vector3d, 3> normal{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                                        Eigen::Vector3d::Zero()};
};

/// A triangle mesh in the target's frame, in metres. Vertices are shared: points that coincide are
/// one vertex, also where parts meet; creases live in the corner normals.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Triangle> triangles;
  std::vector<Part> parts;
  std::vector<Coat> coats = {};  ///< one a triangle, or none of a mesh without textures and colours
  std::vector<std::shared_ptr<const Texture>> textures = {};
  /// Why textures that the file names cannot be drawn, a sentence each.
  std::vector<std::string> lost_textures = {};
  /// What else of the file is not drawn, or is taken otherwise than it says; a clause each.
  std::vector<std::string> notes = {};
};

/// Sets every corner normal to the area-weighted mean of the normals of the faces around that
/// vertex which turn by less than `crease_angle_rad` against the corner's own face.
void compute_corner_normals(Mesh& mesh, double crease_angle_rad);

/// The same for those corners alone whose normal is zero.
void add_missing_normals(Mesh& mesh, double crease_angle_rad);

/// A side of a triangle.
struct HalfEdge {
  int low, high;  ///< its vertices
  int triangle;
  bool is_forward;  ///< the triangle goes from low to high
};

/// All sides of all triangles, those between the same two vertices beside each other.
std::vector<HalfEdge> sorted_half_edges(const Mesh& mesh);

/// The unit normal of a triangle by its winding; zero for a degenerate one.
Eigen::Vector3d face_normal(const Mesh& mesh, const Triangle& triangle);

/// Of each part, whether it is there from outside alone; empty where none is.
std::vector<bool> one_sided_parts(const Mesh& mesh);

/// Whether the eye lies behind a triangle's plane, by its winding.
bool is_seen_from_behind(const Mesh& mesh, const Triangle& triangle, const Eigen::Vector3d& eye_m);

struct Bounds {
  Eigen::Vector3d min_m;
  Eigen::Vector3d max_m;
};

/// The axis-aligned box of the vertices. The mesh must not be empty.
Bounds bounds(const Mesh& mesh);

/// The middle of that box.
Eigen::Vector3d middle_m(const Mesh& mesh);

/// The greatest distance from a point, by default the origin of the target's frame, to a vertex,
/// metres.
double radius_m(const Mesh& mesh, const Eigen::Vector3d& about_m = Eigen::Vector3d::Zero());

}  // namespace sightline
