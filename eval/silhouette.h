// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "scenes/target.h"

namespace sightline {

/// How far from a feature the target's outline shows it: a rounded edge is seen beside its crease.
/// Of a line intersection, where the outlines of its two edges meet; of a corner, the nearest point
/// of its outline. Over the views in which that is to be seen.
struct SilhouetteOffset {
  int views = 0;  ///< 0: never, or a contour, which is no point of the outline
  double median_px = 0, greatest_px = 0;
  double median_m = 0, greatest_m = 0;
};

constexpr int kSilhouetteViews = 300;  ///< uniform on SO(3)
constexpr double kSilhouetteSizePx =
    400;  ///< the diagonal of the target's box, as long in the image

/// Of each of the target's features, from views all round at thirty times its size.
std::vector<SilhouetteOffset> silhouette_offsets(const Target& target);

}  // namespace sightline
