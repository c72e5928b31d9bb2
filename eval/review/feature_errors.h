// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "scenes/target/target.h"

namespace sightline {

/// What may be expected of a feature, from pictures of the target.
struct FeatureError {
  double visible_fraction = 0;  ///< of the views: nothing of the target hides it
  int shown = 0;                ///< the views that show it, in which it was looked for
  int found = 0;
  double median_px = 0;  ///< error of those found
  double p90_px = 0;
};

constexpr int kReviewViews = 60;            ///< a median is known to some 15 % of its size
constexpr double kReviewAttitudeDeg = 0.5;  ///< of the pose from which features are looked for

/// Of each feature of a target with a mesh, in their order: the target is rendered from that many
/// sides (those of `views_all_round`, 400 px to the diagonal of its box) in light from about the
/// camera with 3 grey levels of noise, and features are looked for by `edges_else_contour` from a
/// pose that errs as a first pass leaves it (0.5 degrees, 0.25 % in range, 0.75 px). The same
/// target has the same errors. Needs a renderer.
std::vector<FeatureError> feature_errors(const std::shared_ptr<const Target>& target);

}  // namespace sightline
