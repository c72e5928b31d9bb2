// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "eval/benchmarks/visp_tracker.h"
#include "scenes/mesh/mesh.h"

namespace sightline {

/// What of a mesh ViSP is to track: its creases of 20 degrees and more and, since a rounded body
/// has none, the sides of triangles that are its contour as it is seen from `eye_m`.
VispModel visp_model(const Mesh& mesh, const Eigen::Vector3d& eye_m);

}  // namespace sightline
