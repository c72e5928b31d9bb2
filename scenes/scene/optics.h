// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a real lens does beside bending: the keys of [optics].
#pragma once

#include <vector>

#include "pose/pose.h"
#include "scenes/scene/keys.h"

namespace sightline {

/// A lens with an opening, through every point of which the scene is seen from another place, and
/// with a focal length that depends on the colour. The camera of the scene is that of the opening's
/// middle and of green.
struct Optics {
  double aperture_mm = 0;     ///< diameter of the opening; 0: all distances are sharp
  double focus_m = 0;         ///< distance, along the optical axis, that is sharp
  int aperture_samples = 64;  ///< places in the opening whose images are averaged
  double red_scale = 0;       ///< by which part red's image is larger than green's
  double blue_scale = 0;

  bool has_aperture() const { return aperture_mm > 0; }
  bool has_chromatic_shift() const { return red_scale != 0 || blue_scale != 0; }
};

/// What a file says of the optics. The defaults are those of a frame.
struct OpticsLaw {
  Range aperture_mm = Optics{}.aperture_mm;
  Range focus_m = Optics{}.focus_m;  ///< 0: that of the target's origin
  int aperture_samples = Optics{}.aperture_samples;
  Range red_scale = Optics{}.red_scale;
  Range blue_scale = Optics{}.blue_scale;
};

std::vector<Key> keys_of(OpticsLaw& law, Optics& optics);

/// The optics of one scene, whose target has this pose.
Optics draw_optics(OpticsLaw law, const Pose& cam_from_target, const Draws& draws);

/// What the truth states of the optics; nothing of a pinhole that all colours share.
std::vector<Fact> facts_of(Optics optics);

}  // namespace sightline
