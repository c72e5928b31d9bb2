// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What is known of a pose before its image is looked at: the keys of [prior].
#pragma once

#include <vector>

#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/scene/keys.h"

namespace sightline {

/// The standard deviations of a prior pose about the truth, such as a tracker would hand over.
struct PriorError {
  double attitude_deg = 2;  ///< about each axis of the camera
  double range_fraction = 0.01;
  double lateral_px = 3;  ///< of the target's origin, in u and in v
};

std::vector<Key> keys_of(PriorError& error);

/// What [prior] says. Throws InputError.
PriorError read_prior(const TomlTable& table);

/// A pose that errs from the truth by Gaussian draws of `error`: the attitude by a rotation vector,
/// the range along the line of sight, the origin's pixel by lateral_px.
Pose draw_prior(const Pose& truth_cam_from_target, const Camera& camera, const PriorError& error,
                RandomStream& stream);

}  // namespace sightline
