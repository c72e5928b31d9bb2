// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Studies as tests handle them: changed by hand, and run trial by trial.
#pragma once

#include <variant>

#include "eval/study/study.h"
#include "eval/trial/image_trial.h"
#include "eval/trial/numeric_trial.h"
#include "eval/trial/orientation_trial.h"

namespace sightline {

inline ImageStudy& images_of(Study& study) {
  return std::get<ImageStudy>(study.kind);
}

inline NumericStudy& numeric_of(Study& study) {
  return std::get<NumericStudy>(study.kind);
}

inline OrientationStudy& orientation_of(Study& study) {
  return std::get<OrientationStudy>(study.kind);
}

inline Trial run_trial(const Study& study, int64_t index, Renderer& renderer) {
  return run_image_trial(*study.images(), study.seed, index, renderer);
}

inline TrialRecord run_numeric_trial(const Study& study, int64_t index) {
  return run_numeric_trial(*study.numeric(), study.seed, index);
}

inline TrialRecord run_orientation_trial(const Study& study, int64_t index) {
  return run_orientation_trial(*study.orientation(), study.seed, index);
}

}  // namespace sightline
