// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Marquardt's method for any cost of a pose that can be evaluated with its gradient and Hessian.
// (Sums of squared reprojection errors have a faster way: pose/packed_points.h.)
#pragma once

#include <optional>

#include "pose/kernels/marquardt.h"
#include "pose/pose.h"
#include "pose/solver.h"

namespace sightline {

/// A cost near a pose: cost(delta) ~ cost + gradient . delta + 1/2 delta . hessian delta, where
/// delta = (w, dt) leads from the pose (R, t) to (Exp(w) R, t + dt).
struct LocalModel {
  double cost = 0;
  Vector6d gradient = Vector6d::Zero();
  Matrix6d hessian = Matrix6d::Zero();
};

/// Marquardt's step: minus the solution of (hessian + damping diag(hessian)) delta = gradient.
/// None where that matrix is not positive definite.
std::optional<Vector6d> marquardt_step(const LocalModel& model, double damping);

/// True when a step turns by less than `tolerance` radians and moves by less than that part of the
/// range.
bool is_short_step(const Vector6d& delta, const Pose& pose, double tolerance);

/// What the model says that a step gains.
double promised_decrease(const LocalModel& model, const Vector6d& delta);

/// Where an iteration ended.
struct Minimum {
  PoseStatus status = PoseStatus::kDiverged;  ///< kOk, kDiverged, or kBehindCamera for the start
  Pose pose;
  LocalModel model;  ///< at the pose
  int iterations = 0;
};

/// A cost over poses, as the iteration of pose/kernels/marquardt.h asks for it. `Evaluate` is what
/// `minimise` takes.
template <typename Evaluate>
class CostOfPose {
 public:
  CostOfPose(const Evaluate& evaluate, const Pose& start, double tolerance)
      : evaluate_(evaluate), tolerance_(tolerance), pose_(start) {}

  bool evaluate_start() {
    std::optional<LocalModel> model = evaluate_(pose_);
    if (model) model_ = *model;
    return model.has_value();
  }
  bool propose(double damping) {
    const std::optional<Vector6d> delta = marquardt_step(model_, damping);
    if (!delta) return false;
    delta_ = *delta;
    candidate_ = retract(pose_, delta_);
    return true;
  }
  bool is_short_step() const { return sightline::is_short_step(delta_, pose_, tolerance_); }
  double promise(double /*damping*/) const { return promised_decrease(model_, delta_); }
  double cost() const { return model_.cost; }
  bool evaluate_candidate() {
    candidate_model_ = evaluate_(candidate_);
    return candidate_model_.has_value();
  }
  double candidate_cost() const { return candidate_model_->cost; }
  void accept() {
    pose_ = candidate_;
    model_ = *candidate_model_;
  }
  /// The caller is given the model at the pose: the last step is evaluated as any other.
  void take_last_step() {
    if (evaluate_candidate() && kernel::is_no_worse(candidate_cost(), cost())) accept();
  }

  const Pose& pose() const { return pose_; }
  const LocalModel& model() const { return model_; }

 private:
  const Evaluate& evaluate_;
  double tolerance_;
  Pose pose_;
  LocalModel model_;
  Vector6d delta_;
  Pose candidate_;
  std::optional<LocalModel> candidate_model_;
};

/// The status of a pose for the end of an iteration.
PoseStatus status_of(kernel::FitStatus status);

/// Minimises a cost over poses by Marquardt's method (pose/kernels/marquardt.h) from one start.
/// `evaluate` takes a Pose and returns std::optional<LocalModel>, none where the cost is not
/// defined (a point behind the camera). A step is short when it turns by less than `step_tolerance`
/// radians and moves by less than that part of the range.
template <typename Evaluate>
Minimum minimise(const Pose& start, const Evaluate& evaluate, int max_iterations,
                 double step_tolerance) {
  CostOfPose<Evaluate> problem(evaluate, start, kernel::usable_tolerance(step_tolerance));
  Minimum result;
  result.status = status_of(kernel::marquardt(problem, max_iterations, result.iterations));
  result.pose = problem.pose();
  result.model = problem.model();
  return result;
}

}  // namespace sightline
