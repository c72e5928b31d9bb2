// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "pose/pose.h"
#include "scenes/mesh/mesh.h"

namespace sightline {

/// How much of what is seen of a mesh faces the camera to within 10 degrees: its share of the area
/// in the image, from 0 to 1, what hides what left out of account. Of a cube seen from in front it
/// is nearly 1, of a ball 0.03. The mesh must be in front of the camera.
double facing_share(const Mesh& mesh, const Pose& cam_from_target);

}  // namespace sightline
