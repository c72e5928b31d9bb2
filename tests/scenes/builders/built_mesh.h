// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <numbers>

#include <Eigen/Core>

#include "scenes/mesh/mesh.h"

namespace sightline {

/// Builders round coordinates to the micrometre, so that two points of one place differ by less.
inline constexpr double kGridM = 2e-6;
inline constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

/// The number of the vertex at a point, or -1 where there is none.
inline int vertex_at(const Mesh& mesh, const Eigen::Vector3d& point) {
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    if ((mesh.vertices[v] - point).norm() < kGridM) return static_cast<int>(v);
  }
  return -1;
}

}  // namespace sightline
