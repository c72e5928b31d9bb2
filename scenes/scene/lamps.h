// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lights that are near: the keys of [[lamp]].
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "pose/pose.h"
#include "scenes/scene/keys.h"

namespace sightline {

/// A point that shines to all sides, or into a cone. A white surface that faces it at `distance_m`,
/// on the axis of its cone, has the grey `strength`; elsewhere light falls with the square of the
/// distance, and towards the cone's rim as glTF's KHR_lights_punctual says. It casts no shadow.
struct Lamp {
  Eigen::Vector3d position_in_cam_m = Eigen::Vector3d::Zero();
  double strength = 1;
  double distance_m = 1;
  Eigen::Vector3d direction_in_cam = Eigen::Vector3d::UnitZ();  ///< unit vector, the cone's axis
  double cone_deg = 180;  ///< between axis and rim; 180: it shines to all sides
  double full_deg = 0;    ///< within this angle of the axis it has all its strength
  Eigen::Vector3d colour = Eigen::Vector3d::Ones();  ///< factors: in grey, their luminance
};

/// The share of a lamp's strength that it sends at an angle from its axis, given by its cosine.
double cone_share(const Lamp& lamp, double cosine);

/// What a file says of a lamp.
struct LampLaw {
  Eigen::Vector3d position_m = Lamp{}.position_in_cam_m;
  double spread_m = 0;  ///< added to each of its coordinates, uniform within +-
  Range strength = Lamp{}.strength;
  std::optional<double> distance_m;  ///< none: that of the target's origin from the lamp
  Eigen::Vector3d direction = Lamp{}.direction_in_cam;  ///< of any length but 0
  double cone_deg = Lamp{}.cone_deg;
  double full_deg = Lamp{}.full_deg;
  Eigen::Vector3d colour = Lamp{}.colour;
};

std::vector<Key> keys_of(LampLaw& law);

/// All [[lamp]] of a file. Throws InputError.
std::vector<LampLaw> read_lamps(const TomlTable& file);

/// The lamps of one scene, whose target has this pose.
std::vector<Lamp> draw_lamps(const std::vector<LampLaw>& laws, const Pose& cam_from_target,
                             const Draws& draws);

/// What the truth states of a lamp.
std::vector<Fact> facts_of(const Lamp& lamp);

}  // namespace sightline
