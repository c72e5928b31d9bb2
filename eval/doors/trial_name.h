// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <compare>
#include <cstdint>

namespace sightline {

/// The picture of a target that a trial shows, as other people's files name it: BOP's three
/// numbers. Of images that are rendered here the scene and the instance are 0, and the image is the
/// number under which `sightline render` would write it; of SPEED+ it is the place in the list.
struct TrialName {
  int64_t trial = 0;
  int scene_id = 0;
  int64_t im_id = 0;
  int gt_id = 0;
};

/// A picture alone, whatever trials show it.
struct PictureName {
  int scene_id = 0;
  int64_t im_id = 0;

  auto operator<=>(const PictureName&) const = default;
};

}  // namespace sightline
