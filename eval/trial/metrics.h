// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/mesh/mesh.h"

namespace sightline {

/// Vertex distances between a mesh in the estimated and in the true pose, as the BOP challenge
/// defines them for an object without symmetries.
struct VertexErrors {
  double add_m = 0;    ///< mean distance (average distance of model points)
  double mssd_m = 0;   ///< greatest distance
  double mspd_px = 0;  ///< greatest distance of the projections; infinite behind the camera
};

VertexErrors vertex_errors(const Mesh& mesh, const Camera& camera, const Pose& estimated,
                           const Pose& truth);

}  // namespace sightline
