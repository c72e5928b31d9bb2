// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/light.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace sightline {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

}  // namespace

std::vector<Key> keys_of(LightLaw& law, Light& light) {
  return {
      {"light",
       "ambient",
       &law.ambient,
       {0, 1},
       "",
       "even glow: the grey of a white surface in it; 1 is white",
       &light.ambient},
      {"light",
       "directional",
       &law.directional,
       {0, 1},
       "",
       "distant light: the grey that it adds to a white surface facing it",
       &light.directional},
      {"light",
       "specular",
       &law.specular,
       {0, 1},
       "",
       "strength of the highlights (Blinn 1977)",
       &light.specular},
      {"light",
       "shininess",
       &law.shininess,
       {1, 1000},
       "",
       "exponent of the highlights: the larger, the smaller they are",
       &light.shininess},
      {"light",
       "casts_shadow",
       &law.casts_shadow,
       {},
       "",
       "whether bodies shade each other and themselves from the distant light",
       &light.casts_shadow},
      {"light",
       "cone_deg",
       &law.cone_deg,
       {0, 180},
       "deg",
       "the light comes from a direction uniform within this angle of the camera's; cannot stand "
       "beside phase_deg",
       {},
       "to_light_in_cam"},
      {"light",
       "phase_deg",
       &law.phase_deg,
       {0, 180},
       "deg",
       "angle at the target between the camera and the light",
       {},
       "to_light_in_cam"},
      {"light",
       "azimuth_deg",
       &law.azimuth_deg,
       {-360, 360},
       "deg",
       "side that the light comes from, 0 is image right, 90 down; needs phase_deg beside it",
       {},
       "to_light_in_cam"},
  };
}

LightLaw read_light(const TomlTable& file) {
  LightLaw law;
  Light light;
  const TomlTable table = file.table("light");
  if (table.has("phase_deg") && table.has("cone_deg")) {
    table.fail("cone_deg", "cannot stand beside phase_deg: give one or the other");
  }
  if (table.has("azimuth_deg") && !table.has("phase_deg")) {
    table.fail("azimuth_deg", "needs phase_deg beside it");
  }
  read_keys(file, keys_of(law, light));
  return law;
}

Light draw_light(LightLaw law, const Pose& cam_from_target, const Draws& draws) {
  Light light;
  draw_keys(keys_of(law, light), draws);
  const Eigen::Vector3d to_camera = -cam_from_target.translation.normalized();
  if (!law.phase_deg) {
    RandomStream stream = draws.stream("light");
    light.to_light_in_cam = stream.direction_near(to_camera, law.cone_deg * kDegree);
    return light;
  }
  const double phase = draws(*law.phase_deg, "light.phase_deg") * kDegree;
  const double azimuth = draws(law.azimuth_deg, "light.azimuth_deg") * kDegree;
  const Eigen::Vector3d right = Eigen::Vector3d::UnitY().cross(-to_camera).normalized();
  const Eigen::Vector3d down = (-to_camera).cross(right);
  light.to_light_in_cam = std::cos(phase) * to_camera +
                          std::sin(phase) * (std::cos(azimuth) * right + std::sin(azimuth) * down);
  return light;
}

std::vector<Fact> facts_of(Light light) {
  LightLaw law;
  const Eigen::Vector3d& l = light.to_light_in_cam;
  std::vector<Fact> facts = facts_of(keys_of(law, light));
  facts.insert(facts.begin(), {"to_light_in_cam", std::vector{l.x(), l.y(), l.z()}});
  return facts;
}

}  // namespace sightline
