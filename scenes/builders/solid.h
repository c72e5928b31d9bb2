// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "scenes/mesh/mesh.h"

namespace sightline {

/// Indices of vertices along a line on a surface. A closed line repeats its first index; a line
/// that has shrunk to a point repeats one index throughout.
using Row = std::vector<int>;

/// One closed surface, or the starboard half of one that the plane y = 0 cuts, being built.
class Solid {
 public:
  struct Face {
    std::array<int, 3> vertex;
    int part;
  };

  int add_vertex(const Eigen::Vector3d& point);
  Row add_row(std::span<const Eigen::Vector3d> points, bool closed);

  /// Fills the strip between two rows of the same length: two triangles for each column, split
  /// along the shorter diagonal, one where a side has no length. `part_of_column` paints them.
  void add_strip(const Row& a, const Row& b, const std::function<int(int)>& part_of_column);
  void add_strip(const Row& a, const Row& b, int part);

  /// The same where two strips share the row `crease` and the ends of their other rows: no diagonal
  /// ends at an end of `row`, or both strips would have it.
  void add_strip_to_crease(const Row& row, const Row& crease, int part);

  /// Turns all faces round if they wind inwards. The sign of the volume decides, which also holds
  /// for a starboard half: the missing face lies in a plane through the origin.
  void orient_outwards();

  const std::vector<Eigen::Vector3d>& vertices() const { return vertices_; }
  const std::vector<Face>& faces() const { return faces_; }

 private:
  void add_face(int a, int b, int c, int part);
  void add_column(const Row& a, const Row& b, int column, bool diagonal_rises, int part);

  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Face> faces_;
};

/// A cross-section of a wing, tailplane, fin or pylon.
struct AirfoilSection {
  Eigen::Vector3d leading_edge;
  Eigen::Vector3d trailing_edge;
  double thickness_ratio;  ///< of the chord; zero pinches the surface to a crease that closes it
  int part;                ///< paints the strip from the section before to this one
};

enum class Extent {
  kWhole,
  kStarboardHalf,  ///< of a surface that is symmetric about y = 0
};

/// A surface through NACA four-digit thickness sections (sharp trailing edge), each thickened along
/// `thickness_axis`. Sections at the ends are closed flat unless they are pinched.
Solid lifting_surface(std::span<const AirfoilSection> sections,
                      const Eigen::Vector3d& thickness_axis, Extent extent);

/// A point of the outline that a body of revolution turns about its axis.
struct ProfilePoint {
  double x_m;       ///< forward
  double radius_m;  ///< zero at both ends of the profile
  int part;         ///< paints the band from the point before to this one
};

/// A closed body of revolution about the line through `origin` along x.
Solid body_of_revolution(const Eigen::Vector3d& origin, std::span<const ProfilePoint> profile,
                         int segments);

/// Gathers the solids of the starboard half of a target and mirrors them.
class Assembly {
 public:
  int add_part(std::string name, double albedo);
  void add(Solid solid);

  /// The whole target: everything added and its mirror image in y = 0, joined along that plane.
  /// Coordinates are rounded to the micrometre, so that files do not depend on the last bits of
  /// the C library's sines. A mirrored part is named by `mirrored_name`; when that is its own name
  /// both halves are one part.
  Mesh mirrored(const std::function<std::string(std::string_view)>& mirrored_name) const;

 private:
  Mesh half_;  // without normals
};

}  // namespace sightline
