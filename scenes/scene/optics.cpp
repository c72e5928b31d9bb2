// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/optics.h"

namespace sightline {

std::vector<Key> keys_of(OpticsLaw& law, Optics& optics) {
  constexpr Interval kScales = {-0.05, 0.05};
  return {
      {"optics",
       "aperture_mm",
       &law.aperture_mm,
       {0, 1e5},
       "mm",
       "diameter of the lens's opening: what is nearer or farther than focus_m is blurred; 0: "
       "nothing is",
       &optics.aperture_mm},
      {"optics",
       "focus_m",
       &law.focus_m,
       {0, 1e9},
       "m",
       "distance from the camera, along its axis, that is sharp; 0: that of the target's origin",
       &optics.focus_m},
      {"optics",
       "aperture_samples",
       &law.aperture_samples,
       {4, 1024},
       "",
       "places in the opening from which images are drawn and averaged",
       &optics.aperture_samples},
      {"optics", "red_scale", &law.red_scale, kScales, "",
       "by which part the image in red is larger than that in green, about the principal point; in "
       "grey, red's share of it",
       &optics.red_scale},
      {"optics", "blue_scale", &law.blue_scale, kScales, "", "the same of blue",
       &optics.blue_scale},
  };
}

Optics draw_optics(OpticsLaw law, const Pose& cam_from_target, const Draws& draws) {
  Optics optics;
  draw_keys(keys_of(law, optics), draws);
  if (optics.has_aperture() && optics.focus_m == 0)
    optics.focus_m = cam_from_target.translation.z();
  return optics;
}

std::vector<Fact> facts_of(Optics optics) {
  if (!optics.has_aperture() && !optics.has_chromatic_shift()) return {};
  OpticsLaw law;
  return facts_of(keys_of(law, optics));
}

}  // namespace sightline
