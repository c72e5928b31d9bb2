// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Wavefront .obj files as text. Assimp reads their numbers in single precision, which leaves half a
// metre of georeferenced ones: they are moved near the origin before it sees them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace sightline {

/// The middle of the vertices' box, rounded to whole units, where it is so far from the origin
/// (kFarSizes times the box's diagonal) that single precision loses the mesh; else none.
std::optional<Eigen::Vector3d> far_middle(std::string_view obj);

constexpr double kFarSizes = 100;

/// The text with its vertices moved by minus that much; what else stands in it stays.
std::string moved_obj(std::string_view obj, const Eigen::Vector3d& by);

}  // namespace sightline
