// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/least_squares.h"

#include "pose/minimise.h"

namespace sightline {
namespace {

/// Whether `a` is the outcome to keep rather than `b`, which came before: success before failure,
/// then the lower cost. A start behind the camera has no cost.
bool is_preferable(const kernel::Fit& a, const kernel::Fit& b) {
  if (a.status != b.status) return a.status == kernel::FitStatus::kConverged;
  if (a.status == kernel::FitStatus::kStartBehindCamera) return false;
  return a.model.cost < b.model.cost;
}

}  // namespace

LeastSquares least_squares(const Correspondences& c, std::span<const Pose> cam_from_centred_starts,
                           const LspeOptions& options, std::span<const double> weights) {
  return least_squares(PackedPoints(c, weights), cam_from_centred_starts, options);
}

LeastSquares least_squares(const PackedPoints& points,
                           std::span<const Pose> cam_from_centred_starts,
                           const LspeOptions& options) {
  LeastSquares result;
  if (cam_from_centred_starts.empty()) {
    result.status = PoseStatus::kDegenerate;
    return result;
  }
  kernel::Fit best;
  for (const Pose& start : cam_from_centred_starts) {
    const kernel::Fit fit = points.fit(start, options.max_iterations, options.step_tolerance);
    result.iterations += fit.iterations;
    if (&start == cam_from_centred_starts.data() || is_preferable(fit, best)) best = fit;
  }
  result.status = status_of(best.status);
  result.cam_from_centred = pose_from(best.pose);
  if (result.status == PoseStatus::kBehindCamera) return result;
  result.cost_px2 = 2 * best.model.cost;
  if (result.status != PoseStatus::kOk) return result;

  const std::optional<Matrix6d> covariance = inverse_of(best.model);
  if (covariance) result.unit_covariance = *covariance;
  if (!covariance) result.status = PoseStatus::kDegenerate;
  return result;
}

}  // namespace sightline
