// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/entry/lens_noise.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/LU>

#include "pose/bounds.h"

namespace sightline::entry {
namespace {

std::vector<Eigen::Vector3d> kept_points(const PoseProblem& problem, const PoseEstimate& estimate) {
  std::vector<Eigen::Vector3d> kept;
  for (std::size_t i = 0; i < problem.points_in_target.size(); ++i) {
    const int index = static_cast<int>(i);
    if (std::ranges::binary_search(estimate.removed, index)) continue;
    if (std::ranges::binary_search(estimate.ignored, index)) continue;
    kept.push_back(problem.points_in_target[i]);
  }
  return kept;
}

}  // namespace

bool is_noise_bent(const PoseProblem& problem) {
  // Of a fisheye's angle: nearer the axis it shortens what is seen by less than a tenth.
  constexpr double kFarFromAxis = 0.3;
  // Of the area of the noise, for Brown and Conrady's model, which most cameras have and which
  // hardly bends what most of them see.
  constexpr double kStretch = 0.15;
  const Camera& camera = problem.camera;
  if (is_pinhole(camera.lens)) return false;
  if (!problem.covariances_px2.empty()) return false;
  if (!(problem.sigma_px > 0) || !std::isfinite(problem.sigma_px)) return false;
  const bool is_brown_conrady = std::holds_alternative<BrownConrady>(camera.lens);
  return std::ranges::any_of(problem.pixels, [&](const Eigen::Vector2d& pixel) {
    const Eigen::Vector2d seen((pixel.x() - camera.cx_px) / camera.fx_px,
                               (pixel.y() - camera.cy_px) / camera.fy_px);
    if (!(seen.squaredNorm() > kFarFromAxis * kFarFromAxis)) return false;
    // At the place where the ray is seen, which is near it.
    return !is_brown_conrady || std::abs(lens_jacobian(camera, seen).determinant() - 1) > kStretch;
  });
}

PoseProblem with_bent_noise(PoseProblem problem) {
  const double variance_px2 = problem.sigma_px * problem.sigma_px;
  problem.covariances_px2.assign(problem.pixels.size(), variance_px2 * Eigen::Matrix2d::Identity());
  return problem;
}

PoseEstimate in_pixels(PoseEstimate estimate, const PoseSolver& solver,
                       const PoseProblem& problem) {
  const double sigma_px = problem.sigma_px;
  if (estimate.noise_px) *estimate.noise_px *= sigma_px;
  if (estimate.residual_rms_px) *estimate.residual_rms_px *= sigma_px;
  if (estimate.status != PoseStatus::kOk) return estimate;
  if (solver.unit_covariance_is_whitened) {
    estimate.unit_covariance /= sigma_px * sigma_px;
    return estimate;
  }
  const auto bound = cramer_rao_bound(problem.camera, kept_points(problem, estimate),
                                      estimate.cam_from_target, 1.0);
  if (bound) estimate.unit_covariance = bound->covariance;
  return estimate;
}

}  // namespace sightline::entry
