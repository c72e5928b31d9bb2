// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace sightline {

/// How many bytes a number of a type takes in a binary .ply; 0 of what is no type.
size_t bytes_of_ply_type(const std::string& type);

/// Where a .ply has its vertices, whose coordinates are double precision, as georeferenced scans
/// have them (Turk, The PLY polygon file format, 1994).
struct PlyPoints {
  enum class Format { kAscii, kLittleEndian, kBigEndian };
  Format format = Format::kAscii;
  size_t begin = 0;  ///< of the first vertex, bytes from the file's begin
  size_t count = 0;
  std::array<size_t, 3> place{};  ///< x, y, z in a vertex: bytes, or words of an ascii line
  size_t stride = 0;              ///< bytes, of a binary vertex
};

/// None where the file is no .ply, its vertices do not come first, one of their properties is a
/// list, or x, y and z are single precision, which loses nothing in the library.
std::optional<PlyPoints> double_points(std::string_view ply);

/// The middle of the vertices, rounded to whole units, where it lies over kFarSizes (obj_text.h)
/// diagonals of their box from the origin; none of a file that is torn.
std::optional<Eigen::Vector3d> far_middle(const PlyPoints& points, std::string_view ply);

/// The file with `by` subtracted from every vertex, in double precision, and all else as it was.
std::string moved_ply(std::string_view ply, const PlyPoints& points, const Eigen::Vector3d& by);

}  // namespace sightline
