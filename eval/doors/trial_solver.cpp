// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/doors/trial_solver.h"

#include <utility>

namespace sightline {

TrialSolver built_in(const PoseSolver& solver) {
  return {.name = std::string(solver.name),
          .summary = std::string(solver.summary),
          .evaluation_only = solver.evaluation_only,
          .is_recorded = false,
          .solve = [solver](const SolverQuestion& question) -> SolverAnswer {
            // Studies record what the solver itself says, and judge by the truth.
            SolverOptions options = question.options;
            options.is_judged = false;
            PoseEstimate estimate = solver.solve(question.problem, options);
            const auto outcome = from_string<EstimateOutcome>(to_string(estimate.status));
            return {outcome, std::move(estimate)};
          }};
}

}  // namespace sightline
