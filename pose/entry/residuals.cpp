// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/entry/residuals.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "pose/camera.h"
#include "pose/robust.h"

namespace sightline::entry {
namespace {

constexpr double kTestLevel = 1e-3;
/// Of the normal law: beyond it lies a thousandth.
constexpr double kTestQuantile = 3.0902323061678132;
/// Of the focal length: residuals as small come from rounding.
constexpr double kRounding = 1e-9;

}  // namespace

bool Residuals::look_like_noise() const {
  if (!std::isfinite(squares)) return false;
  if (!(degrees() > 0) || squares <= rounding) return true;
  if (sigma > 0) {
    // The chi-square quantile by the cube root of Wilson and Hilferty (1931).
    const double spread = 2 / (9 * degrees());
    const double root = 1 - spread + kTestQuantile * std::sqrt(spread);
    return squares <= sigma * sigma * degrees() * root * root * root;
  }
  if (degrees() <= 2) return true;
  // The share of one point of two coordinates has a beta law, its tail in closed form.
  const double others = std::max(1 - largest / squares, 0.0);
  return static_cast<double>(kept) * std::pow(others, degrees() / 2 - 1) >= kTestLevel;
}

Residuals residuals_of(const PoseProblem& problem, const PoseEstimate& estimate,
                       const Pose& cam_from_target) {
  Residuals result;
  const Camera& camera = problem.camera;
  const bool is_whitened = !problem.covariances_px2.empty();
  result.sigma = is_whitened ? 1 : problem.sigma_px;
  auto removed = estimate.removed.begin();
  auto ignored = estimate.ignored.begin();
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    const int index = static_cast<int>(i);
    const bool is_removed = removed != estimate.removed.end() && *removed == index;
    const bool is_ignored = ignored != estimate.ignored.end() && *ignored == index;
    if (is_removed) ++removed;
    if (is_ignored) ++ignored;
    if (is_removed || is_ignored) continue;
    ++result.kept;
    const Eigen::Vector3d x = cam_from_target * problem.points_in_target[i];
    double square = std::numeric_limits<double>::infinity(), square_px2 = square;
    if (x.z() > 0) {
      const Eigen::Vector2d r =
          pixel_from_normalised(camera, x.head<2>() / x.z()) - problem.pixels[i];
      square_px2 = r.squaredNorm();
      square = is_whitened ? r.dot(problem.covariances_px2[i].inverse() * r) : square_px2;
    }
    result.squares += square;
    result.squares_px2 += square_px2;
    result.largest = std::max(result.largest, square);
    result.largest_px2 = std::max(result.largest_px2, square_px2);
  }
  const double rounding_px = kRounding * std::max(camera.fx_px, camera.fy_px);
  const double per_px2 = is_whitened && result.largest_px2 > 0  //
                             ? result.largest / result.largest_px2
                             : 1;
  result.rounding = rounding_px * rounding_px * per_px2 * static_cast<double>(result.kept);
  return result;
}

Residuals residuals_of(const PoseProblem& problem, const PoseEstimate& estimate) {
  return residuals_of(problem, estimate, estimate.cam_from_target);
}

bool is_clearly_better(const Residuals& challenger, const Residuals& holder) {
  constexpr double kChance = 1e-4;
  constexpr double kChanceQuantile = 3.719;
  if (!(challenger.degrees() > 0) || !(holder.squares > holder.rounding)) return false;
  if (!std::isfinite(challenger.squares)) return false;
  if (!(holder.degrees() > 0)) return false;
  const double few = std::pow(kChance, -2 / challenger.degrees());
  const double many = std::exp(2 * kChanceQuantile / std::sqrt(challenger.degrees()));
  const double ratio = (holder.squares / holder.degrees()) /
                       (std::max(challenger.squares, 1e-300) / challenger.degrees());
  return ratio > 2 * std::max(few, many);
}

}  // namespace sightline::entry
