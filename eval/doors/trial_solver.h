// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/doors/trial_name.h"
#include "eval/records/names.h"
#include "pose/solver.h"

namespace sightline {

class ExternalProcess;
struct QuestionImage;

/// What a solver is asked in one trial.
struct SolverQuestion {
  const PoseProblem& problem;
  const SolverOptions& options;
  const std::vector<std::string>& features;  ///< the name of each point
  TrialName trial;
  /// The image that the points are of; null where there is none.
  const QuestionImage* image = nullptr;
};

/// What it answers: with outcome kOk a pose, otherwise why there is none.
struct SolverAnswer {
  EstimateOutcome outcome = EstimateOutcome::kNoEstimate;
  PoseEstimate estimate;  ///< `removed` are places among the points that it was asked for
};

/// Who estimates the pose in the trials of a study: a solver of this program's catalogue, or a
/// guest: a file of estimates, a process, a function of whoever embeds the program. All that comes
/// after the answer is the same for each of them.
struct TrialSolver {
  std::string name;
  std::string summary;
  /// Is told the truth (PoseProblem::true_inliers): exists to judge others by.
  bool evaluation_only = false;
  /// Its estimates were made before, from the images as they are, so that it cannot be asked again
  /// with other points.
  bool is_recorded = false;
  /// Looks at the image itself: the points tell it at most where to begin, and it removes none.
  bool looks_at_image = false;
  /// That answers; null: none does. Only a run may ask it (eval/doors/external_process.h).
  std::shared_ptr<ExternalProcess> process = nullptr;
  std::function<SolverAnswer(const SolverQuestion&)> solve;
};

/// A solver of the catalogue.
TrialSolver built_in(const PoseSolver& solver);

}  // namespace sightline
