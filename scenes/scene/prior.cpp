// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/prior.h"

#include <algorithm>

#include "pose/angles.h"

namespace sightline {

std::vector<Key> keys_of(PriorError& error) {
  return {
      {"prior",
       "attitude_deg",
       &error.attitude_deg,
       {0, 90},
       "deg",
       "standard deviation of the prior attitude about each axis of the camera"},
      {"prior",
       "range_percent",
       Percent{&error.range_fraction},
       {0, 20},
       "%",
       "standard deviation of the prior range"},
      {"prior",
       "lateral_px",
       &error.lateral_px,
       {0, 1000},
       "px",
       "standard deviation of the target's origin in the image, in u and in v"},
  };
}

PriorError read_prior(const TomlTable& table) {
  PriorError error;
  for (const Key& key : keys_of(error)) read_key(table, key);
  return error;
}

Pose draw_prior(const Pose& truth_cam_from_target, const Camera& camera, const PriorError& error,
                RandomStream& stream) {
  const Eigen::Vector3d& t = truth_cam_from_target.translation;
  Pose prior;
  prior.rotation = rotation_from_vector(error.attitude_deg * kDegree * stream.normal3()) *
                   truth_cam_from_target.rotation;
  const double range_scale = std::max(0.5, 1 + error.range_fraction * stream.normal());
  const double x_over_z = t.x() / t.z() + error.lateral_px / camera.fx_px * stream.normal();
  const double y_over_z = t.y() / t.z() + error.lateral_px / camera.fy_px * stream.normal();
  prior.translation = range_scale * t.z() * Eigen::Vector3d(x_over_z, y_over_z, 1);
  return prior;
}

}  // namespace sightline
