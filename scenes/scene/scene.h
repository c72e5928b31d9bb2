// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/random/random.h"
#include "scenes/target/target.h"

namespace sightline {

/// The numbers of samples that a pixel may have.
inline constexpr std::array kSampleCounts = {1, 4, 8, 16, 32, 64, 256};

/// One distant light and an even glow: grey = albedo (ambient + directional max(0, n . l)) +
/// specular max(0, n . h)^shininess, h half way between light and eye (Blinn 1977), where
/// n . l > 0 and no shadow falls.
struct Light {
  Eigen::Vector3d to_light_in_cam = -Eigen::Vector3d::UnitZ();  ///< unit vector; default: headlight
  double ambient = 0.30;
  double directional = 0.75;
  double specular = 0;
  double shininess = 20;
  bool casts_shadow = false;  ///< all bodies shade each other and themselves from `directional`
};

enum class BackgroundKind {
  kUniform,  ///< `level` everywhere
  kSky,      ///< from level - contrast / 2 at one side to level + contrast / 2 at the other
  kClouds,   ///< fractal noise about `level`
  kStars,    ///< point sources on `level`
  kImage,    ///< a picture, scaled to cover the image
};

std::string_view to_string(BackgroundKind kind);

/// What lies behind all bodies; linear, 1 is white, at the resolution of the image.
struct Background {
  BackgroundKind kind = BackgroundKind::kUniform;
  double level = 0.15;
  double contrast = 0.2;  ///< of a sky, from side to side; of clouds, twice their sd
  double angle_deg = 90;  ///< of a sky: where it brightens to; 0 is image right, 90 is down
  double cloud_px = 120;  ///< of clouds: the size of the largest
  double stars_per_megapixel = 200;
  double star_level = 1;  ///< the light of the brightest star, in white pixels
  std::shared_ptr<const std::vector<float>> picture;  ///< of an image: rows of grey, 1 is white
  int picture_width = 0;
  uint32_t seed = 0;  ///< of clouds and stars
};

/// Paint on every surface of the main target: stripes across its x axis.
struct Livery {
  double contrast = 0;  ///< how much darker every other stripe is, of its part's albedo
  double stripe_m = 2;
};

/// How the target moves against the camera while the shutter is open; the pose of the scene is that
/// of mid-exposure.
struct Motion {
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();   ///< rotation vector, camera's axes
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();  ///< of the target's origin
  int samples = 9;  ///< poses, evenly spaced in time, whose images are averaged

  bool is_still() const { return rotation_rad.isZero(0) && translation_m.isZero(0); }
};

/// What lies between the light on the focal plane and the numbers in the file.
struct Sensor {
  double psf_sigma_px = 0.7;       ///< Gaussian point spread
  double gain = 1;                 ///< of the signal and its noise, before rounding
  double read_noise_grey = 3;      ///< standard deviation in grey levels of 255, whatever the depth
  double full_well_electrons = 0;  ///< photon noise: electrons at white; 0 is none
  int bits = 8;                    ///< 1 to 16; white is the largest number
  bool is_srgb = false;            ///< numbers encoded as sRGB says; moves edges by some 0.1 px
  double dead_fraction = 0;        ///< of the pixels are black
  double hot_fraction = 0;         ///< of the pixels are white
  uint64_t defect_seed = 0;        ///< which pixels those are: the same in all of a sensor's frames
};

/// A body beside the main target: another target whose truth is told too, or an occluder.
struct OtherBody {
  std::shared_ptr<const Target> target;
  Pose cam_from_target;
  bool is_occluder = false;  ///< it hides and shades, but nobody asks for its pose
};

/// Everything that determines a frame, but for the noise's random stream.
struct Scene {
  std::shared_ptr<const Target> target;  ///< the main one, whose pose a study asks for
  Camera camera;
  Pose cam_from_target;
  std::vector<OtherBody> others;
  Light light;
  Background background;
  Livery livery;
  Motion motion;
  Sensor sensor;
  int samples_per_pixel = 16;  ///< one of kSampleCounts; see the renderer
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

/// Why a scene cannot be imaged, in words for the user (a body reaches behind the camera, or the
/// main target's projected box lies outside the image); empty when it can.
std::string why_not_imageable(const Scene& scene);

}  // namespace sightline
