// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/lamps.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "pose/angles.h"

namespace sightline {
namespace {

void require_sound(const TomlTable& table, const LampLaw& law) {
  if (!(law.direction.norm() > 0)) table.fail("direction", "is zero, must point somewhere");
  if (law.full_deg > law.cone_deg) {
    table.fail("full_deg", fmt::format("is {}, must be at most cone_deg, which is {}", law.full_deg,
                                       law.cone_deg));
  }
  require_within(table, "colour", law.colour, {0, 1});
}

Lamp draw_lamp(const LampLaw& law, const Pose& cam_from_target, RandomStream& stream) {
  Lamp lamp;
  lamp.position_in_cam_m = law.position_m;
  for (double& coordinate : lamp.position_in_cam_m) {
    coordinate += stream.uniform(-law.spread_m, law.spread_m);
  }
  lamp.strength = law.strength.draw(stream);
  lamp.distance_m =
      law.distance_m.value_or((cam_from_target.translation - lamp.position_in_cam_m).norm());
  lamp.direction_in_cam = law.direction.normalized();
  lamp.cone_deg = law.cone_deg;
  lamp.full_deg = law.full_deg;
  lamp.colour = law.colour;
  return lamp;
}

}  // namespace

double cone_share(const Lamp& lamp, double cosine) {
  if (lamp.cone_deg >= 180) return 1;
  constexpr double kSharpestRim = 1e-3;
  const double rim = std::cos(lamp.cone_deg * kDegree);
  const double width = std::max(kSharpestRim, std::cos(lamp.full_deg * kDegree) - rim);
  const double share = std::clamp((cosine - rim) / width, 0.0, 1.0);
  return share * share;
}

std::vector<Key> keys_of(LampLaw& law) {
  return {
      {"lamp",
       "position_m",
       &law.position_m,
       {},
       "m",
       "where a lamp stands, in the camera's axes (x right, y down, z forward)",
       {},
       "position_in_cam_m"},
      {"lamp",
       "spread_m",
       &law.spread_m,
       {0, 1e9},
       "m",
       "added to each of these, uniform within +-",
       {},
       "position_in_cam_m"},
      {"lamp",
       "strength",
       &law.strength,
       {0, 1e6},
       "",
       "the grey of a white surface that faces it at distance_m; elsewhere light falls with the "
       "square of the distance, and a lamp casts no shadow",
       {},
       "strength"},
      {"lamp",
       "distance_m",
       &law.distance_m,
       {1e-9, 1e9},
       "m",
       "see strength",
       {},
       "distance_m",
       false,
       "from the lamp to the target's origin"},
      {"lamp",
       "direction",
       &law.direction,
       {},
       "",
       "the axis of the cone that it shines into, in the camera's axes",
       {},
       "direction_in_cam"},
      {"lamp",
       "cone_deg",
       &law.cone_deg,
       {0.01, 180},
       "deg",
       "angle between that axis and the rim; 180: it shines to all sides",
       {},
       "cone_deg"},
      {"lamp",
       "full_deg",
       &law.full_deg,
       {0, 180},
       "deg",
       "within this angle of the axis it has all its strength, which falls to the rim",
       {},
       "full_deg"},
      {"lamp",
       "colour",
       &law.colour,
       {},
       "",
       "its red, green and blue, factors from 0 to 1; in grey their luminance counts",
       {},
       "colour"},
  };
}

std::vector<LampLaw> read_lamps(const TomlTable& file) {
  std::vector<LampLaw> laws;
  for (const TomlTable& table : file.tables("lamp")) {
    LampLaw law;
    for (const Key& key : keys_of(law)) read_key(table, key);
    require_sound(table, law);
    laws.push_back(law);
  }
  return laws;
}

std::vector<Lamp> draw_lamps(const std::vector<LampLaw>& laws, const Pose& cam_from_target,
                             const Draws& draws) {
  std::vector<Lamp> lamps;
  RandomStream stream = draws.stream("lamp");
  for (const LampLaw& law : laws) lamps.push_back(draw_lamp(law, cam_from_target, stream));
  return lamps;
}

std::vector<Fact> facts_of(const Lamp& lamp) {
  const auto three = [](const Eigen::Vector3d& v) { return std::vector{v.x(), v.y(), v.z()}; };
  return {{"position_in_cam_m", three(lamp.position_in_cam_m)},
          {"strength", lamp.strength},
          {"distance_m", lamp.distance_m},
          {"direction_in_cam", three(lamp.direction_in_cam)},
          {"cone_deg", lamp.cone_deg},
          {"full_deg", lamp.full_deg},
          {"colour", three(lamp.colour)}};
}

}  // namespace sightline
