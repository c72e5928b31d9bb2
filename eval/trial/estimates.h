// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "eval/datasets/symmetries.h"
#include "eval/doors/registration_solver.h"
#include "eval/records/records.h"
#include "eval/study/study.h"

namespace sightline {

/// The observations of a trial that were found, as a problem for the solvers, and which they are.
struct FoundPoints {
  PoseProblem problem;
  std::vector<int> slots;  ///< point -> index into the trial's observations
  TrialName trial;
  const SolverOptions* options = nullptr;  ///< of the trial's condition; null: the study's
  /// Of the target, which the true pose is known up to; null: it has none.
  const Symmetries* symmetries = nullptr;
  std::optional<QuestionImage> image;  ///< that they are of; none of a numeric study
};

/// What each solver of the study makes of the points, against the truth in the trial's record. Only
/// solvers for evaluation are told which points are inliers. `seed` is the whole study's.
std::vector<EstimateRecord> estimates_of(const PoseStudy& study, uint64_t seed,
                                         const FoundPoints& found, const TrialRecord& record);

/// The estimates of a trial without observations: every solver failed, for that reason.
std::vector<EstimateRecord> failed_estimates(const Solving& solving, EstimateOutcome reason);

}  // namespace sightline
