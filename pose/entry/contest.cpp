// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/entry/contest.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pose/entry/cleaning.h"
#include "pose/entry/residuals.h"
#include "pose/starts.h"

namespace sightline::entry {
namespace {

bool is_free_start_idle(const PoseProblem& problem, const Residuals& residuals) {
  return residuals.sigma > 0 && residuals.look_like_noise() &&
         is_clearly_solid(problem.points_in_target);
}

PoseEstimate from_points_in_front(const PoseSolver& solver, const PoseProblem& problem,
                                  const SolverOptions& options) {
  const Pose& initial = *problem.initial_cam_from_target;
  const Part part = without_points(problem, points_behind(problem, initial));
  return of_whole(solver.core(part.problem, options), part);
}

}  // namespace

void contest(const PoseSolver& solver, const PoseProblem& problem, const SolverOptions& options,
             PoseEstimate& estimate) {
  if (problem.points_in_target.size() < kMinimumPosePoints) return;
  const bool is_ok = estimate.status == PoseStatus::kOk;
  Residuals residuals;
  if (is_ok) residuals = residuals_of(problem, estimate);
  if (is_ok && is_free_start_idle(problem, residuals)) return;

  PoseProblem free_problem = problem;
  free_problem.initial_cam_from_target.reset();
  PoseEstimate free = solver.core(free_problem, options);
  const bool is_free_ok = free.status == PoseStatus::kOk;
  if (is_ok) {
    const bool is_better = is_free_ok && is_clearly_better(residuals_of(problem, free), residuals);
    if (is_better) estimate = std::move(free);
    return;
  }
  const bool is_behind = estimate.status == PoseStatus::kBehindCamera;
  if (is_free_ok) estimate = std::move(free);
  if (!is_behind) return;
  PoseEstimate in_front = from_points_in_front(solver, problem, options);
  if (in_front.status != PoseStatus::kOk) return;
  const bool is_better = !is_free_ok || is_clearly_better(residuals_of(problem, in_front),
                                                          residuals_of(problem, estimate));
  if (is_better) estimate = std::move(in_front);
}

}  // namespace sightline::entry
