// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Motion while the shutter is open: the keys of [motion].
#pragma once

#include <vector>

#include <Eigen/Core>

#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/scene/keys.h"

namespace sightline {

/// How the target moves against the camera while the shutter is open; the pose of the scene is that
/// of mid-exposure, of a rolling shutter of the middle row's.
struct Motion {
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();   ///< rotation vector, camera's axes
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();  ///< of the target's origin
  int samples = 9;  ///< poses of an exposure, evenly spaced in time, whose images are averaged
  /// Of a rolling shutter: the time from the first row's exposure to the last's, in exposures. The
  /// pose of the scene is that of the middle row's.
  double readout = 0;

  bool is_still() const { return rotation_rad.isZero(0) && translation_m.isZero(0); }
};

/// What a file says of the motion.
struct MotionLaw {
  Range rotation_deg;  ///< turned during the exposure, about a uniform axis
  Range shift_px;      ///< of the target's origin, to a uniform side
  int samples = Motion{}.samples;
  Range readout = Motion{}.readout;
};

std::vector<Key> keys_of(MotionLaw& law, Motion& motion);

/// The motion in one scene, whose target has this pose.
Motion draw_motion(MotionLaw law, const Camera& camera, const Pose& cam_from_target,
                   const Draws& draws);

/// What the truth states of a motion.
std::vector<Fact> facts_of(Motion motion);

}  // namespace sightline
