// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/fit_points.h"

#include <utility>
#include <vector>

#include "pose/minimax_null.h"

namespace sightline {
namespace {

PackedPoints packed(const FitPoints& points) {
  std::vector<Eigen::Matrix2d> weights(points.correspondences.size(), Eigen::Matrix2d::Zero());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t point = points.index(i);
    weights[point] =
        points.whitening.empty()
            ? Eigen::Matrix2d(Eigen::Matrix2d::Identity())
            : Eigen::Matrix2d(points.whitening[point].transpose() * points.whitening[point]);
  }
  return PackedPoints(points.correspondences, weights);
}

}  // namespace

std::optional<Reprojection> reproject(const FitPoints& points, std::size_t i,
                                      const Pose& cam_from_centred) {
  const std::size_t index = points.index(i);
  std::optional<Reprojection> r = reproject(points.correspondences, index, cam_from_centred);
  if (!r || points.whitening.empty()) return r;
  const Eigen::Matrix2d& whitening = points.whitening[index];
  r->residual_px = (whitening * r->residual_px).eval();
  r->jacobian = (whitening * r->jacobian).eval();
  return r;
}

LeastSquares least_squares(const FitPoints& points, std::span<const Pose> cam_from_centred_starts,
                           const LspeOptions& options) {
  return least_squares(packed(points), cam_from_centred_starts, options);
}

std::optional<Matrix6d> unit_covariance(const FitPoints& points, const Pose& cam_from_centred) {
  const std::optional<Matrix6d> information = information_at(packed(points), cam_from_centred);
  return information ? inverse_information(*information) : std::nullopt;
}

PoseEstimate with_pose(PoseEstimate estimate, const FitPoints& points,
                       const Pose& cam_from_centred) {
  // For unit noise, whatever the points were weighted by.
  const FitPoints unweighted = {points.correspondences, points.kept, {}};
  const std::optional<Matrix6d> covariance = unit_covariance(unweighted, cam_from_centred);
  const Correspondences& c = points.correspondences;
  const Pose cam_from_target = from_centred(cam_from_centred, c);
  // A target that was pushed to the end of the numbers, where all its points fall on one pixel.
  const bool is_finite = covariance && covariance->allFinite() && is_valid(cam_from_target);
  if (!is_finite) {
    estimate.status = PoseStatus::kDegenerate;
    return estimate;
  }
  estimate.cam_from_target = cam_from_target;
  estimate.unit_covariance = covariance_from_centred(*covariance, cam_from_centred, c);
  return estimate;
}

PoseEstimate with_minimax_pose(PoseEstimate estimate, const FitPoints& points,
                               const Pose& cam_from_centred) {
  estimate = with_pose(std::move(estimate), points, cam_from_centred);
  estimate.unit_covariance *= minimax_variance_factor(points.size());
  return estimate;
}

PoseEstimate with_least_squares(PoseEstimate estimate, const FitPoints& points,
                                const Pose& cam_from_centred_start, const LspeOptions& options) {
  const LeastSquares fit = least_squares(points, {&cam_from_centred_start, 1}, options);
  estimate.iterations += fit.iterations;
  estimate.status = fit.status;
  if (fit.status != PoseStatus::kOk) return estimate;
  return with_pose(std::move(estimate), points, fit.cam_from_centred);
}

}  // namespace sightline
