// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/light.h"

#include <cmath>

#include <Eigen/Geometry>

#include "pose/angles.h"

namespace sightline {
namespace {

// The direction at an angle from the one to the camera, towards a side of the image.
Eigen::Vector3d direction_at(const Eigen::Vector3d& to_camera, double phase, double azimuth) {
  const Eigen::Vector3d right = Eigen::Vector3d::UnitY().cross(-to_camera).normalized();
  const Eigen::Vector3d down = (-to_camera).cross(right);
  return std::cos(phase) * to_camera +
         std::sin(phase) * (std::cos(azimuth) * right + std::sin(azimuth) * down);
}

}  // namespace

std::vector<Key> keys_of(LightLaw& law, Light& light) {
  return {
      {"light",
       "ambient",
       &law.ambient,
       {0, 1},
       "",
       "even glow: the grey of a white surface in it; 1 is white",
       &light.ambient,
       {},
       false,
       "0.3, in an [environment] 0"},
      {"light",
       "occlusion",
       &law.is_glow_occluded,
       {},
       "",
       "whether bodies keep the even glow and the light of an [environment] from each other and "
       "from "
       "themselves (ambient occlusion)",
       &light.is_glow_occluded},
      {"light",
       "directional",
       &law.directional,
       {0, 1},
       "",
       "distant light: the grey that it adds to a white surface facing it",
       &light.directional,
       {},
       false,
       "0.75, in an [environment] 0"},
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
       "radius_deg",
       &law.radius_deg,
       {0, 10},
       "deg",
       "angular radius of the distant light, by which its shadows are soft; of the sun from the "
       "Earth 0.2666",
       &light.radius_deg},
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
      {"light",
       "second",
       &law.second,
       {0, 1},
       "",
       "second distant light, without shadow: the grey that it adds to a white surface facing it",
       &light.second},
      {"light",
       "second_phase_deg",
       &law.second_phase_deg,
       {0, 180},
       "deg",
       "angle at the target between the camera and the second light",
       {},
       "to_second_in_cam"},
      {"light",
       "second_azimuth_deg",
       &law.second_azimuth_deg,
       {-360, 360},
       "deg",
       "side that the second light comes from",
       {},
       "to_second_in_cam"},
      {"light",
       "colour",
       &law.colour,
       {},
       "",
       "red, green and blue of the distant light, factors from 0 to 1; in grey its luminance "
       "counts",
       {},
       "colour"},
      {"light",
       "second_colour",
       &law.second_colour,
       {},
       "",
       "the same of the second light",
       {},
       "second_colour"},
  };
}

LightLaw read_light(const TomlTable& file) {
  LightLaw law;
  Light light;
  const TomlTable table = file.table("light");
  if (table.has("phase_deg") && table.has("cone_deg")) {
    table.fail("cone_deg", "cannot stand beside phase_deg: give one or the other");
  }
  if (table.has("radius_deg") && !table.flag("casts_shadow", false)) {
    table.fail("radius_deg", "needs casts_shadow = true beside it");
  }
  if (table.has("azimuth_deg") && !table.has("phase_deg")) {
    table.fail("azimuth_deg", "needs phase_deg beside it");
  }
  read_keys(file, keys_of(law, light));
  require_within(table, "colour", law.colour, {0, 1});
  require_within(table, "second_colour", law.second_colour, {0, 1});
  return law;
}

Light draw_light(LightLaw law, const Pose& cam_from_target, const Draws& draws) {
  Light light;
  draw_keys(keys_of(law, light), draws);
  light.colour = law.colour;
  light.second_colour = law.second_colour;
  const Eigen::Vector3d to_camera = -cam_from_target.translation.normalized();
  if (light.second > 0) {
    light.to_second_in_cam =
        direction_at(to_camera, draws(law.second_phase_deg, "light.second_phase_deg") * kDegree,
                     draws(law.second_azimuth_deg, "light.second_azimuth_deg") * kDegree);
  }
  if (!law.phase_deg) {
    RandomStream stream = draws.stream("light");
    light.to_light_in_cam = stream.direction_near(to_camera, law.cone_deg * kDegree);
    return light;
  }
  const double phase = draws(*law.phase_deg, "light.phase_deg") * kDegree;
  const double azimuth = draws(law.azimuth_deg, "light.azimuth_deg") * kDegree;
  light.to_light_in_cam = direction_at(to_camera, phase, azimuth);
  return light;
}

std::vector<Fact> facts_of(Light light) {
  LightLaw law;
  const Eigen::Vector3d& l = light.to_light_in_cam;
  std::vector<Fact> facts = facts_of(keys_of(law, light));
  facts.insert(facts.begin(), {"to_light_in_cam", std::vector{l.x(), l.y(), l.z()}});
  const auto add = [&facts](const char* name, const Eigen::Vector3d& v) {
    facts.push_back({name, std::vector{v.x(), v.y(), v.z()}});
  };
  // What was never there is not in the truth.
  std::erase_if(facts, [&light](const Fact& fact) {
    return (fact.name == "second" && !(light.second > 0)) ||
           (fact.name == "radius_deg" && !(light.radius_deg > 0)) ||
           (fact.name == "occlusion" && !light.is_glow_occluded);
  });
  if (light.second > 0) add("to_second_in_cam", light.to_second_in_cam);
  if (light.colour != Light{}.colour) add("colour", light.colour);
  if (light.second_colour != Light{}.second_colour) add("second_colour", light.second_colour);
  return facts;
}

}  // namespace sightline
