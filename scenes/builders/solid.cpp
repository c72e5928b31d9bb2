// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/builders/solid.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

namespace sightline {
namespace {

constexpr double kTieM = 1e-6;    // diagonals closer than this are of one length on any machine
constexpr int kChordPoints = 20;  // from leading to trailing edge, on either side

// Chord fractions, dense at the leading edge: the first facet stands at 67 degrees or more to the
// chord for sections down to 9 %, so upper and lower side meet at less than 46 degrees.
double chord_fraction(int i) {
  return i == kChordPoints ? 1 : 1 - std::cos(std::numbers::pi / 2 * i / kChordPoints);
}

// Half thickness over chord of a NACA four-digit section (Abbott and von Doenhoff 1959), the last
// coefficient -0.1036 instead of -0.1015 so that the trailing edge is sharp.
double naca_half_thickness(double x, double ratio) {
  const double shape =
      0.2969 * std::sqrt(x) + x * (-0.1260 + x * (-0.3516 + x * (0.2843 - x * 0.1036)));
  return 5 * ratio * shape;
}

// One side of a section. The rows run from the leading to the trailing edge on the side that the
// thickness axis points to and back on the other, so that both sides wind alike; all share their
// ends, and a pinched section's sides are one row.
struct SectionSide {
  Row surface;
  Row chord;  // only of the first and the last section
};

using SectionSides = std::vector<SectionSide>;  // one, or two if the extent is whole

SectionSides add_section(Solid& solid, const AirfoilSection& section, const Eigen::Vector3d& axis,
                         Extent extent, bool is_end) {
  const Eigen::Vector3d chord = section.trailing_edge - section.leading_edge;
  SectionSide near;
  SectionSide far;
  for (int i = 0; i <= kChordPoints; ++i) {
    const double x = chord_fraction(i);
    const Eigen::Vector3d on_chord = section.leading_edge + x * chord;
    const double half_m = naca_half_thickness(x, section.thickness_ratio) * chord.norm();
    const bool is_shared = i == 0 || i == kChordPoints || section.thickness_ratio == 0;
    const int above = solid.add_vertex(is_shared ? on_chord : on_chord + half_m * axis);
    const auto other_vertex = [&](double offset_m) {
      return is_shared ? above : solid.add_vertex(on_chord + offset_m * axis);
    };
    near.surface.push_back(above);
    far.surface.push_back(other_vertex(-half_m));
    if (is_end) near.chord.push_back(other_vertex(0));
  }
  if (extent == Extent::kStarboardHalf) return {near};
  far.chord = near.chord;
  std::reverse(far.surface.begin(), far.surface.end());
  std::reverse(far.chord.begin(), far.chord.end());
  return {near, far};
}

Eigen::Vector3d rounded_to_micrometre(const Eigen::Vector3d& point) {
  return (point * 1e6).array().round().matrix() / 1e6 + Eigen::Vector3d::Zero();
}

// The compact mesh: without vertices that no triangle uses.
Mesh without_unused_vertices(Mesh mesh) {
  std::vector<int> new_index(mesh.vertices.size(), -1);
  std::vector<Eigen::Vector3d> used;
  for (Triangle& triangle : mesh.triangles) {
    for (int& v : triangle.vertex) {
      if (new_index[v] < 0) {
        new_index[v] = static_cast<int>(used.size());
        used.push_back(mesh.vertices[v]);
      }
      v = new_index[v];
    }
  }
  mesh.vertices = std::move(used);
  return mesh;
}

}  // namespace

int Solid::add_vertex(const Eigen::Vector3d& point) {
  vertices_.push_back(point);
  return static_cast<int>(vertices_.size()) - 1;
}

Row Solid::add_row(std::span<const Eigen::Vector3d> points, bool closed) {
  Row row;
  for (const Eigen::Vector3d& point : points) row.push_back(add_vertex(point));
  if (closed) row.push_back(row.front());
  return row;
}

void Solid::add_face(int a, int b, int c, int part) {
  if (a != b && b != c && c != a) faces_.push_back({{a, b, c}, part});
}

// The diagonal rises from this column of a to the next of b, or falls from the next of a to this
// one of b.
void Solid::add_column(const Row& a, const Row& b, int column, bool diagonal_rises, int part) {
  const int next = column + 1;
  if (diagonal_rises) {
    add_face(a[column], a[next], b[next], part);
    add_face(a[column], b[next], b[column], part);
  } else {
    add_face(a[column], a[next], b[column], part);
    add_face(a[next], b[next], b[column], part);
  }
}

void Solid::add_strip(const Row& a, const Row& b, const std::function<int(int)>& part_of_column) {
  const int columns = static_cast<int>(a.size()) - 1;
  for (int i = 0; i < columns; ++i) {
    const double rising_m = (vertices_[a[i]] - vertices_[b[i + 1]]).norm();
    const double falling_m = (vertices_[a[i + 1]] - vertices_[b[i]]).norm();
    add_column(a, b, i, rising_m < falling_m - kTieM, part_of_column(i));
  }
}

void Solid::add_strip(const Row& a, const Row& b, int part) {
  add_strip(a, b, [part](int) { return part; });
}

void Solid::add_strip_to_crease(const Row& row, const Row& crease, int part) {
  const int columns = static_cast<int>(row.size()) - 1;
  for (int i = 0; i < columns; ++i) add_column(row, crease, i, 2 * i >= columns, part);
}

void Solid::orient_outwards() {
  double volume = 0;
  for (const Face& face : faces_) {
    const auto& [a, b, c] = face.vertex;
    volume += vertices_[a].dot(vertices_[b].cross(vertices_[c]));
  }
  if (volume >= 0) return;
  for (Face& face : faces_) std::swap(face.vertex[1], face.vertex[2]);
}

Solid lifting_surface(std::span<const AirfoilSection> sections,
                      const Eigen::Vector3d& thickness_axis, Extent extent) {
  Solid solid;
  SectionSides before = add_section(solid, sections.front(), thickness_axis, extent, true);
  for (const auto& [surface, chord] : before) {
    solid.add_strip(chord, surface, sections.front().part);
  }
  for (const AirfoilSection& section : sections.subspan(1)) {
    const bool is_end = &section == &sections.back();
    const bool is_pinched = section.thickness_ratio == 0;
    SectionSides sides = add_section(solid, section, thickness_axis, extent, is_end);
    for (size_t i = 0; i < sides.size(); ++i) {
      const auto& [surface, chord] = sides[i];
      if (is_pinched) {
        solid.add_strip_to_crease(before[i].surface, surface, section.part);
      } else {
        solid.add_strip(before[i].surface, surface, section.part);
        if (is_end) solid.add_strip(surface, chord, section.part);
      }
    }
    before = std::move(sides);
  }
  solid.orient_outwards();
  return solid;
}

Solid body_of_revolution(const Eigen::Vector3d& origin, std::span<const ProfilePoint> profile,
                         int segments) {
  Solid solid;
  Row before;
  for (const ProfilePoint& point : profile) {
    const Eigen::Vector3d centre = origin + point.x_m * Eigen::Vector3d::UnitX();
    Row row;
    if (point.radius_m == 0) {
      row.assign(segments + 1, solid.add_vertex(centre));
    } else {
      std::vector<Eigen::Vector3d> circle;
      for (int i = 0; i < segments; ++i) {
        const double angle = 2 * std::numbers::pi * i / segments;
        circle.push_back(centre +
                         point.radius_m * Eigen::Vector3d(0, std::cos(angle), std::sin(angle)));
      }
      row = solid.add_row(circle, true);
    }
    if (!before.empty()) solid.add_strip(before, row, point.part);
    before = std::move(row);
  }
  solid.orient_outwards();
  return solid;
}

int Assembly::add_part(std::string name, double albedo) {
  half_.parts.push_back({std::move(name), albedo});
  return static_cast<int>(half_.parts.size()) - 1;
}

void Assembly::add(Solid solid) {
  const int offset = static_cast<int>(half_.vertices.size());
  for (const Eigen::Vector3d& point : solid.vertices()) {
    half_.vertices.push_back(rounded_to_micrometre(point));
  }
  for (const Solid::Face& face : solid.faces()) {
    const auto& [a, b, c] = face.vertex;
    half_.triangles.push_back({.vertex = {a + offset, b + offset, c + offset}, .part = face.part});
  }
}

Mesh Assembly::mirrored(const std::function<std::string(std::string_view)>& mirrored_name) const {
  Mesh mesh = half_;
  std::vector<int> mirror_vertex;
  for (const Eigen::Vector3d& point : half_.vertices) {
    mirror_vertex.push_back(
        static_cast<int>(point.y() == 0 ? mirror_vertex.size() : mesh.vertices.size()));
    if (point.y() != 0) mesh.vertices.push_back({point.x(), -point.y(), point.z()});
  }
  std::vector<int> mirror_part;
  for (const Part& part : half_.parts) {
    const std::string name = mirrored_name(part.name);
    const bool shared = name == part.name;
    mirror_part.push_back(static_cast<int>(shared ? mirror_part.size() : mesh.parts.size()));
    if (!shared) mesh.parts.push_back({name, part.albedo});
  }
  for (const Triangle& triangle : half_.triangles) {
    const auto& [a, b, c] = triangle.vertex;
    mesh.triangles.push_back({.vertex = {mirror_vertex[a], mirror_vertex[c], mirror_vertex[b]},
                              .part = mirror_part[triangle.part]});
  }
  return without_unused_vertices(std::move(mesh));
}

}  // namespace sightline
