// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/motion.h"

#include <cmath>
#include <numbers>

#include "pose/angles.h"

namespace sightline {
namespace {

std::vector<double> numbers_of(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

std::vector<Key> keys_of(MotionLaw& law, Motion& motion) {
  return {
      {"motion",
       "rotation_deg",
       &law.rotation_deg,
       {0, 90},
       "deg",
       "angle by which the target turns during the exposure, about a uniform axis",
       {},
       "rotation_rad"},
      {"motion",
       "shift_px",
       &law.shift_px,
       {0, 1000},
       "px",
       "distance by which the target's origin moves during the exposure, to a uniform side",
       {},
       "translation_m"},
      {"motion",
       "samples",
       &law.samples,
       {2, 256},
       "",
       "poses of an exposure, evenly spaced in time, whose images are averaged",
       &motion.samples},
      {"motion",
       "readout",
       &law.readout,
       {0, 100},
       "",
       "of a rolling shutter: time from the first row's exposure to the last's, in exposures",
       &motion.readout},
  };
}

Motion draw_motion(MotionLaw law, const Camera& camera, const Pose& cam_from_target,
                   const Draws& draws) {
  Motion motion;
  draw_keys(keys_of(law, motion), draws);
  RandomStream stream = draws.stream("motion");
  const double angle = draws(law.rotation_deg, "motion.rotation_deg") * kDegree;
  motion.rotation_rad = angle * stream.direction_near(Eigen::Vector3d::UnitZ(), std::numbers::pi);
  const double shift_m =
      draws(law.shift_px, "motion.shift_px") / camera.fx_px * cam_from_target.translation.z();
  const double side = stream.uniform(0, 2 * std::numbers::pi);
  motion.translation_m = shift_m * Eigen::Vector3d(std::cos(side), std::sin(side), 0);
  return motion;
}

std::vector<Fact> facts_of(Motion motion) {
  MotionLaw law;
  std::vector<Fact> facts = {{"rotation_rad", numbers_of(motion.rotation_rad)},
                             {"translation_m", numbers_of(motion.translation_m)}};
  for (Fact& fact : facts_of(keys_of(law, motion))) {
    const bool is_of_no_readout = fact.name == "readout" && motion.readout == 0;
    if (!is_of_no_readout) facts.push_back(std::move(fact));
  }
  return facts;
}

}  // namespace sightline
