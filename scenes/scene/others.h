// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Bodies beside the main target: the keys of [[other]].
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/scene/keys.h"
#include "scenes/target/target.h"

namespace sightline {

/// A body beside the main target: another target whose truth is told too, or an occluder.
struct OtherBody {
  std::shared_ptr<const Target> target;
  Pose cam_from_target;
  bool is_occluder = false;  ///< it hides and shades, but nobody asks for its pose
};

/// How bodies beside the main target are placed: `count` times, each by draws of its own.
struct OtherLaw {
  std::string name;  ///< of the target
  double scale = 1;  ///< of its mesh
  std::shared_ptr<const Target> target;
  bool is_occluder = true;
  int count = 1;
  Range offset_px{-100, 100};       ///< of its origin from the main target's, in u and in v
  Range range_fraction{0.8, 0.95};  ///< of its z to the main target's
  std::optional<Range> angle_deg;   ///< each of its three angles; none: uniform on SO(3)
  bool keeps_apart = false;         ///< its box cuts that of no body before it
};

/// The bodies of one scene beside its main target.
struct DrawnOthers {
  std::vector<OtherBody> bodies;
  std::string problem;  ///< why one of them has no place, in words; empty: all have one
};

std::vector<Key> keys_of(OtherLaw& law);

/// All [[other]] of a file. Throws InputError.
std::vector<OtherLaw> read_others(const TomlTable& file);

/// The bodies of one scene, whose main target has this pose. One that is to keep apart is drawn
/// anew until it does, a thousand times at most.
DrawnOthers draw_others(const std::vector<OtherLaw>& laws, const Camera& camera, const Mesh& target,
                        const Pose& cam_from_target, const Draws& draws);

}  // namespace sightline
