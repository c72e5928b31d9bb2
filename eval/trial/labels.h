// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>

#include "eval/records/names.h"
#include "eval/study/label_limits.h"
#include "features/observation.h"
#include "renderer/frame.h"
#include "scenes/scene/scene.h"

namespace sightline {

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
