// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>

#include "eval/datasets/sightings.h"
#include "eval/records/names.h"
#include "renderer/frame.h"

namespace sightline {

/// An image of a data set in place of a rendered one.
struct SetFrame {
  Scene scene;  ///< target, camera, pose and bits alone: nobody knows the rest
  Frame frame;
  std::optional<EstimateOutcome> problem;  ///< why there is none
};

/// Reads the picture of a sighting as grey levels, as they are stored, and states the truth that
/// its pose tells: pixels, depth and ids of the target's mesh alone. Where the set has a mask of
/// what is seen of the instance, what it leaves out belongs to another body, and a feature with
/// none of it within two pixels is hidden.
SetFrame read_set_frame(const std::shared_ptr<const Target>& target, int bits,
                        const Sighting& sighting);

}  // namespace sightline
