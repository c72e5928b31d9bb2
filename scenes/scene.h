// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/random.h"
#include "scenes/target.h"

namespace sightline {

/// One distant light and an even glow: grey = albedo (ambient + directional max(0, n . l)).
struct Light {
  Eigen::Vector3d to_light_in_cam = -Eigen::Vector3d::UnitZ();  ///< unit vector; default: headlight
  double ambient = 0.30;
  double directional = 0.75;
};

/// What lies between the light on the focal plane and the numbers in the file.
struct Sensor {
  double psf_sigma_px = 0.7;       ///< Gaussian point spread
  double read_noise_grey = 3;      ///< standard deviation in grey levels of 255, whatever the depth
  double full_well_electrons = 0;  ///< photon noise: electrons at white; 0 is none
  int bits = 8;                    ///< 1 to 16; white is the largest number
};

/// Everything that determines a frame, but for the noise's random stream.
struct Scene {
  std::shared_ptr<const Target> target;
  Camera camera;
  Pose cam_from_target;
  Light light;
  double background = 0.15;  ///< uniform, of white
  Sensor sensor;
  int samples_per_pixel = 16;  ///< 1, 4, 16 or 64, on a square grid
};

/// The standard deviations of a prior pose about the truth, such as a tracker would hand over.
struct PriorError {
  double attitude_deg = 2;  ///< about each axis of the camera
  double range_fraction = 0.01;
  double lateral_px = 3;  ///< of the target's origin, in u and in v
};

/// A pose that errs from the truth by Gaussian draws of `error`: the attitude by a rotation vector,
/// the range along the line of sight, the origin's pixel by lateral_px.
Pose draw_prior(const Pose& truth_cam_from_target, const Camera& camera, const PriorError& error,
                RandomStream& stream);

/// Why a scene cannot be imaged, in words for the user (the target reaches behind the camera, or
/// its projected box lies outside the image); empty when it can.
std::string why_not_imageable(const Scene& scene);

}  // namespace sightline
