// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "pose/camera.h"
#include "scenes/target/target.h"

namespace sightline {

/// How far from a feature the target's outline shows it: a rounded edge is seen beside its crease.
/// Of a line intersection, where the outlines of its two edges meet; of a corner, the nearest point
/// of its outline. Over the views in which that is to be seen.
struct SilhouetteOffset {
  int views = 0;  ///< 0: never, or a contour, which is no point of the outline
  double median_px = 0, greatest_px = 0;
  double median_m = 0, greatest_m = 0;  ///< the same at the feature's distance
};

/// A camera, and where the target is before it.
struct TargetView {
  Camera camera;
  Pose cam_from_target;
};

constexpr int kSilhouetteViews = 300;  ///< enough for a median
constexpr double kSilhouetteSizePx =
    400;  ///< the diagonal of the target's box, as long in the image

/// So many views of the target, uniform on SO(3), at thirty times its size.
std::vector<TargetView> views_all_round(const Target& target);

/// Of each of these features of the target (indices), in their order, over the views.
std::vector<SilhouetteOffset> silhouette_offsets(const Target& target,
                                                 std::span<const int> features,
                                                 std::span<const TargetView> views);

}  // namespace sightline
