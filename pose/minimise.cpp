// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/minimise.h"

#include <Eigen/Cholesky>

namespace sightline {

std::optional<Vector6d> marquardt_step(const LocalModel& model, double damping) {
  Matrix6d damped = model.hessian;
  damped.diagonal() *= 1 + damping;
  const Eigen::LLT<Matrix6d> cholesky(damped);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  const Vector6d delta = -cholesky.solve(model.gradient);
  return delta.allFinite() ? std::optional(delta) : std::nullopt;
}

bool is_short_step(const Vector6d& delta, const Pose& pose, double tolerance) {
  return delta.head<3>().norm() < tolerance &&
         delta.tail<3>().norm() < tolerance * pose.translation.norm();
}

double promised_decrease(const LocalModel& model, const Vector6d& delta) {
  return -delta.dot(model.gradient) - 0.5 * delta.dot(model.hessian * delta);
}

PoseStatus status_of(kernel::FitStatus status) {
  switch (status) {
    case kernel::FitStatus::kConverged:
      return PoseStatus::kOk;
    case kernel::FitStatus::kStartBehindCamera:
      return PoseStatus::kBehindCamera;
    case kernel::FitStatus::kNotConverged:
      break;
  }
  return PoseStatus::kDiverged;
}

}  // namespace sightline
