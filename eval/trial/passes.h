// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "eval/records/records.h"
#include "eval/study/study.h"
#include "features/observation.h"
#include "renderer/frame.h"
#include "renderer/renderer.h"

namespace sightline {

/// What the passes of extraction over one image gave.
struct Extraction {
  std::vector<Observation>
      observations;      ///< of the last pass, in the order of the study's features
  Pose cam_from_target;  ///< that the last pass looked around
  std::optional<EstimateOutcome> problem{};  ///< why a guest has no observations, if so
};

/// Extracts the study's features from a trial's frame around the prior in its record: a guest's
/// answer where the set-up has one; otherwise in as many passes as it asks for: extract,
/// solve (orpe_weighed, which the prior helps where few features are found; where the set-up uses
/// lines, consensus with them), gate against the prior, extract again around the pose found. A pass
/// that finds less than half of what the one before found is dropped. Of the scene only what a user
/// would know is used: the camera, and, to remove the extractors' bias, target, light and
/// background level. A guest sees the grey picture.
Extraction extract(const ImageStudy& study, const TrialRecord& record, const Scene& scene,
                   const Frame& frame, Renderer& renderer);

}  // namespace sightline
