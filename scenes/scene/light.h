// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The light: the keys of [light].
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "pose/pose.h"
#include "scenes/scene/keys.h"

namespace sightline {

/// One distant light and an even glow: grey = albedo (ambient + directional max(0, n . l)) +
/// specular max(0, n . h)^shininess, h half way between light and eye (Blinn 1977), where
/// n . l > 0 and no shadow falls.
struct Light {
  Eigen::Vector3d to_light_in_cam = -Eigen::Vector3d::UnitZ();  ///< unit vector; default: headlight
  double ambient = 0.30;
  /// The even glow, a panorama's too, reaches as much of a surface as bodies leave open of the sky.
  bool is_glow_occluded = false;
  double directional = 0.75;
  double specular = 0;
  double shininess = 20;
  bool casts_shadow = false;  ///< all bodies shade each other and themselves from `directional`
  /// Of the distant light's disc. Shadows are as soft as it makes them; all else comes from its
  /// middle.
  double radius_deg = 0;
  /// A second distant light (the Earth's, a wall's), which adds to `directional` as that does, but
  /// has no highlights on dull surfaces and casts no shadow.
  double second = 0;
  Eigen::Vector3d to_second_in_cam = -Eigen::Vector3d::UnitZ();  ///< unit vector
  /// Red, green and blue of the distant lights, factors: of pictures in grey their
  /// luminance.
  Eigen::Vector3d colour = Eigen::Vector3d::Ones();
  Eigen::Vector3d second_colour = Eigen::Vector3d::Ones();
};

/// What a file says of the light. The defaults are those of a frame, but for the direction.
struct LightLaw {
  Range ambient = Light{}.ambient;
  bool is_glow_occluded = Light{}.is_glow_occluded;
  Range directional = Light{}.directional;
  Range specular = Light{}.specular;
  Range shininess = Light{}.shininess;
  bool casts_shadow = Light{}.casts_shadow;
  Range radius_deg = Light{}.radius_deg;
  double cone_deg = 45;  ///< the direction is uniform in that cone about the one to the camera ...
  std::optional<Range> phase_deg;  ///< ... or at this angle from it,
  Range azimuth_deg{0, 360};       ///< towards this side; 0 is image right, 90 down
  Range second = Light{}.second;
  Range second_phase_deg{0, 180};  ///< as above, of the second light
  Range second_azimuth_deg{0, 360};
  Eigen::Vector3d colour = Light{}.colour;
  Eigen::Vector3d second_colour = Light{}.second_colour;
};

std::vector<Key> keys_of(LightLaw& law, Light& light);

/// Throws InputError.
LightLaw read_light(const TomlTable& file);

/// The light of one scene, whose target has this pose.
Light draw_light(LightLaw law, const Pose& cam_from_target, const Draws& draws);

/// What the truth states of a light: of a second one and of colours where there are such.
std::vector<Fact> facts_of(Light light);

}  // namespace sightline
