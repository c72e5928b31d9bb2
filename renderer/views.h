// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a picture is averaged of: moments of the exposure, and places in the lens's opening.
#pragma once

#include "pose/camera.h"
#include "scenes/scene/scene.h"

namespace sightline {

/// The scene as it is seen at one moment from one place.
struct View {
  Scene scene;                ///< as it is seen in the middle of the exposure from this place
  Pose cam_from_target;       ///< of the main target at this moment
  double begin = 0, end = 0;  ///< the moments it stands for, in exposures from the middle
};

/// Whether rows are exposed at different moments that make a difference.
bool is_rolling(const Scene& scene);

/// How many views a scene has, which share all moments in which some row is exposed evenly among
/// them; one of a scene that is still and seen by a pinhole.
int view_count(const Scene& scene);

/// One of them, from 0. An opening needs optics.focus_m above 0.
View view_at(const Scene& scene, int index);

/// The share that a view has of a row of an image of so many rows, of a rolling shutter: rows are
/// read one after the other during motion.readout exposures, and each is exposed for one. The
/// shares of a row sum to 1.
double share_of(const View& view, const Scene& scene, int row, int rows);

/// A camera whose image is larger by this part about its principal point.
Camera scaled(Camera camera, double part);

}  // namespace sightline
