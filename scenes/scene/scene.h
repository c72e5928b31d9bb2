// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/scene/background.h"
#include "scenes/scene/colouring.h"
#include "scenes/scene/environment.h"
#include "scenes/scene/imaging.h"
#include "scenes/scene/lamps.h"
#include "scenes/scene/light.h"
#include "scenes/scene/livery.h"
#include "scenes/scene/materials.h"
#include "scenes/scene/motion.h"
#include "scenes/scene/optics.h"
#include "scenes/scene/others.h"
#include "scenes/scene/sensor.h"
#include "scenes/target/target.h"

namespace sightline {

/// Everything that determines a frame, but for the noise's random stream.
struct Scene {
  std::shared_ptr<const Target> target;  ///< the main one, whose pose a study asks for
  Camera camera;
  Pose cam_from_target;
  std::vector<OtherBody> others;
  std::string misplaced;  ///< why one of these has no place (draw_others); empty: all have one
  Light light;
  std::vector<Lamp> lamps;
  Environment environment;
  Background background;
  Livery livery;
  std::vector<DrawnMaterial> materials;  ///< as the targets of this scene wear them
  Motion motion;
  Optics optics;
  Sensor sensor;
  Colouring colouring;
  int samples_per_pixel = kSamplesPerPixel;  ///< one of kSampleCounts; see the renderer
};

/// Why a scene cannot be imaged, in words for the user (the main target lies behind the camera, the
/// projected box of what of it is in front lies outside the image, or a body beside it has no
/// place); empty when it can. Bodies that reach behind the camera are seen as far as they are in
/// front.
std::string why_not_imageable(const Scene& scene);

}  // namespace sightline
