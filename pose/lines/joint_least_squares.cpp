// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <utility>

#include "pose/lines/joint.h"
#include "pose/minimise.h"
#include "pose/solver.h"

namespace sightline::lines {
namespace {

bool is_better(const kernel::Fit& fit, const std::optional<kernel::Fit>& best) {
  if (fit.status == kernel::FitStatus::kStartBehindCamera) return false;
  if (!best) return true;
  if (fit.status != best->status) return fit.status == kernel::FitStatus::kConverged;
  return fit.model.cost < best->model.cost;
}

/// Whether the fit from the initial pose converged near it: elsewhere is where it was not meant.
bool is_near(const kernel::Fit& fit, const Pose& initial) {
  constexpr double kNearCosine = 0.88;  // of 0.5 radians; a turn by a has the trace 1 + 2 cos a
  const Pose pose = pose_from(fit.pose);
  return fit.status == kernel::FitStatus::kConverged &&
         pose.rotation.cwiseProduct(initial.rotation).sum() > 1 + 2 * kNearCosine;
}

/// The best fit from the initial pose or, where there is none or it leads nowhere near, from all
/// starts; and the iterations of all.
std::optional<kernel::Fit> best_fit(const Joint& joint, const PoseProblem& problem,
                                    const SolverOptions& options, int& iterations) {
  std::optional<kernel::Fit> best;
  const auto is_good_from = [&](const Pose& start) {
    bool has_all = false;
    const kernel::Fit fitted =
        fit_all(joint, start, options.lspe.max_iterations, options.lspe.step_tolerance, has_all);
    iterations += fitted.iterations;
    if (has_all && is_better(fitted, best)) best = fitted;
    return has_all && is_near(fitted, start);
  };
  const std::optional<Pose>& initial = joint.initial_cam_from_centred;
  if (initial && is_good_from(*initial)) return best;
  SolverOptions unjudged = options;
  unjudged.is_judged = false;
  const PoseEstimate from_points = find_pose_solver("lspe")->solve(points_of(problem), unjudged);
  for (const Pose& start : starts_of(joint, from_points)) is_good_from(start);
  if (from_points.status == PoseStatus::kOk) return best;
  for (const Pose& start : starts_over_attitudes(joint)) is_good_from(start);
  return best;
}

}  // namespace

PoseEstimate solve_lspe(const PoseProblem& problem, const SolverOptions& options) {
  PreparedJoint prepared = prepare_joint(problem);
  Joint& joint = prepared.joint;
  PoseEstimate estimate;
  estimate.status = prepared.status;
  estimate.ignored = std::move(joint.ignored);
  estimate.ignored_lines = std::move(joint.ignored_lines);
  if (estimate.status != PoseStatus::kOk) return estimate;

  const std::optional<kernel::Fit> best = best_fit(joint, problem, options, estimate.iterations);
  estimate.status = best ? status_of(best->status) : PoseStatus::kBehindCamera;
  if (estimate.status != PoseStatus::kOk) return estimate;
  const std::optional<Matrix6d> covariance = inverse_of(best->model);
  if (!covariance) {
    estimate.status = PoseStatus::kDegenerate;
    return estimate;
  }
  const Pose pose = pose_from(best->pose);
  estimate.cam_from_target = from_centred(pose, joint.points);
  estimate.unit_covariance = covariance_from_centred(*covariance, pose, joint.points);
  if (joint.is_noise_known) estimate.covariance = estimate.unit_covariance;
  return estimate;
}

}  // namespace sightline::lines
