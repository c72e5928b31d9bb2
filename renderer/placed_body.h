// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "pose/pose.h"
#include "scenes/mesh/mesh.h"

namespace sightline {

/// A body as it stands before the camera. Its triangle i has the id first_id + i in a frame.
struct PlacedBody {
  const Mesh* mesh = nullptr;
  Pose cam_from_body;
  uint32_t first_id = 1;
  double stripe_contrast = 0;
  double stripe_m = 1;
};

}  // namespace sightline
