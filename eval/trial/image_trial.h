// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "eval/datasets/set_frame.h"
#include "eval/records/records.h"
#include "eval/study/study.h"
#include "features/observation.h"
#include "registration/model_image.h"
#include "renderer/frame.h"
#include "renderer/renderer.h"

namespace sightline {

/// A trial with the evidence behind its record, for the report's pictures.
struct Trial {
  TrialRecord record;
  Scene scene;
  Frame frame;
  std::vector<Observation> observations;  ///< in the order of the study's features
};

/// Runs trial number `index` of a study with this seed from scene to errors. It depends on nothing
/// else: the same in any shard, order or process. `files` spares reading those of a data set again
/// for every trial that is of the same image.
Trial run_image_trial(const ImageStudy& study, uint64_t seed, int64_t index, Renderer& renderer,
                      SetFiles& files);
Trial run_image_trial(const ImageStudy& study, uint64_t seed, int64_t index, Renderer& renderer);

/// A trial with the evidence behind what is recorded of it, of a study that asks processes: its
/// scene and frame are made anew, and what the program's own extractors find in it; what processes
/// answered, and what the solvers made of it, is as recorded. It asks no process.
Trial recall_image_trial(const ImageStudy& study, uint64_t seed, const TrialRecord& recorded,
                         Renderer& renderer);

/// The target's mesh at a pose beside a trial's frame, as the study's registration compares them;
/// none of a study without one.
std::optional<ModelImage> model_beside(const ImageStudy& study, const Trial& trial,
                                       const Pose& cam_from_target);

/// The second half of run_image_trial: what is extracted from the trial's frame around its prior,
/// how that stands against the truth, and what the solvers make of it.
void extract_and_solve(const ImageStudy& study, uint64_t seed, Trial& trial, Renderer& renderer);

}  // namespace sightline
