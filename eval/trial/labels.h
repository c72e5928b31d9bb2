// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <string_view>

#include "eval/study/label_limits.h"
#include "features/observation.h"
#include "renderer/frame.h"
#include "scenes/scene/scene.h"

namespace sightline {

/// What an observation is, held against the truth.
enum class ObservationLabel {
  kInlier,             ///< found where the feature is
  kWrongLine,          ///< a line was taken that is no edge of the feature
  kWrongIntersection,  ///< both lines are edges of the feature, but meet far from it
  kWrongPoint,         ///< another point of the target was taken for it
  kClutter,            ///< what was taken is not of the target: background or another body
  kHidden,             ///< something was found, though the feature is not to be seen
  kMissing,            ///< nothing was found, though the feature is to be seen
  kAbsent,             ///< nothing was found, and nothing is to be seen
};

/// Words for tables and files: "inlier", "wrong line", ...
std::string_view to_string(ObservationLabel label);

/// An observation against the truth; what does not apply is NaN.
struct LabelledObservation {
  ObservationLabel label = ObservationLabel::kAbsent;
  bool is_visible = false;  ///< on the image, hidden by nothing, and of contrast enough
  double error_px = std::numeric_limits<double>::quiet_NaN();
  double error_sigmas = std::numeric_limits<double>::quiet_NaN();
  bool is_outlier = false;
};

/// Labels an observation of the scene's main target by the feature's true pixel and visibility, by
/// its true edges, and by what the pixels of the evidence truly show (the frame's ids).
LabelledObservation label(const Observation& observation, const Scene& scene, const Frame& frame,
                          const LabelLimits& limits);

/// The contrast of a feature of the main target, grey levels of 255: between 3 px inside and 3 px
/// outside its outline as the true pose shows it, the median along it, of a line intersection's two
/// edges the lesser. 0 where too little of an edge is to be seen.
double contrast_grey(int feature, const Scene& scene, const Frame& frame);

}  // namespace sightline
