// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/trial_runner.h"

#include "eval/trial/image_trial.h"
#include "eval/trial/numeric_trial.h"
#include "eval/trial/orientation_trial.h"

namespace sightline {

TrialRunner::TrialRunner(const Study& study, const RendererOptions& renderer) : study_(study) {
  if (study.images() != nullptr) renderer_.emplace(renderer);
}

TrialRecord TrialRunner::run(int64_t index, uint64_t seed) {
  if (const ImageStudy* images = study_.images()) {
    return run_image_trial(*images, seed, index, *renderer_, files_).record;
  }
  if (const NumericStudy* numeric = study_.numeric()) {
    return run_numeric_trial(*numeric, seed, index);
  }
  return run_orientation_trial(std::get<OrientationStudy>(study_.kind), seed, index);
}

}  // namespace sightline
