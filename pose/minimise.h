// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Marquardt's method for any cost of a pose that can be evaluated with its gradient and Hessian.
// (Sums of squared reprojection errors have a faster way: pose/packed_points.h.)
#pragma once

#include <array>
#include <cstddef>
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
      : evaluate_(evaluate), tolerance_(tolerance) {
    best().pose = start;
  }

  bool evaluate_start() { return take_model(best()); }
  bool propose(double damping) {
    const std::optional<Vector6d> delta = marquardt_step(*best().model, damping);
    if (delta) delta_ = *delta;
    return delta.has_value();
  }
  bool is_short_step() const { return sightline::is_short_step(delta_, best().pose, tolerance_); }
  double promise(double /*damping*/) const { return promised_decrease(*best().model, delta_); }
  double cost() const { return best().model->cost; }
  bool evaluate_candidate() {
    candidate().pose = retract(best().pose, delta_);
    return take_model(candidate());
  }
  double candidate_cost() const { return candidate().model->cost; }
  void accept() { best_ = 1 - best_; }
  /// The caller is given the model at the pose: the last step is evaluated as any other.
  void take_last_step() {
    if (evaluate_candidate() && kernel::is_no_worse(candidate_cost(), cost())) accept();
  }

  const Pose& pose() const { return best().pose; }
  const std::optional<LocalModel>& model() const { return best().model; }

 private:
  struct Place {
    Pose pose;
    std::optional<LocalModel> model;
  };
  Place& best() { return places_[best_]; }
  const Place& best() const { return places_[best_]; }
  Place& candidate() { return places_[1 - best_]; }
  const Place& candidate() const { return places_[1 - best_]; }

  bool take_model(Place& place) {
    place.model = evaluate_(place.pose);
    return place.model.has_value();
  }

  const Evaluate& evaluate_;
  double tolerance_;
  Vector6d delta_;
  /// One is the best so far and the other the candidate; they change parts when it is accepted.
  std::array<Place, 2> places_;
  std::size_t best_ = 0;
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
  if (problem.model()) result.model = *problem.model();
  return result;
}

}  // namespace sightline
