// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/entry/judgement.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pose/entry/residuals.h"
#include "pose/entry/rivals.h"
#include "pose/starts.h"

namespace sightline::entry {
namespace {

/// The chance, at most, that data without any pose are called significant.
constexpr double kChanceOfNonsense = 0.01;

/// Of the image's area: noise of 3 % of its side.
constexpr double kWidestNoise2 = 9e-4;

/// The area over which the pixels are spread, were they spread evenly; those on a line are taken
/// for an image of a quarter of its length each way.
double image_area_px2(const std::vector<Eigen::Vector2d>& pixels) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero(), squares = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& pixel : pixels) {
    if (!pixel.allFinite()) continue;
    const Eigen::Vector2d offset = pixel - pixels.front();
    sum += offset;
    squares += offset.cwiseAbs2();
  }
  const double n = static_cast<double>(pixels.size());
  const Eigen::Vector2d variance = (squares / n - (sum / n).cwiseAbs2()).cwiseMax(0);
  return 12 * std::max(std::sqrt(variance.x() * variance.y()), variance.maxCoeff() / 16);
}

/// The logarithm of the number of ways to choose k of n.
double log_choices(double n, double k) {
  return std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1);
}

/// Whether fewer than one of a hundred clouds of pixels without any pose would agree as well with
/// one of the poses of three points (a-contrario: Moisan and Stival 2004). The points that are not
/// among the three each fall within the largest residual by chance.
bool is_significant(const PoseProblem& problem, const Residuals& residuals) {
  const double n = static_cast<double>(problem.pixels.size());
  const double k = static_cast<double>(residuals.kept);
  if (k <= 3) return false;
  const double area = image_area_px2(problem.pixels);
  // Noise that is not known, or is not what was said, may be so large and no larger: rough
  // agreement in most of the image is what a mirrored target has, too.
  const bool is_known_noise = residuals.sigma > 0 && residuals.look_like_noise();
  if (!is_known_noise && residuals.squares_px2 > 2 * k * kWidestNoise2 * area) return false;
  const double chance = std::numbers::pi * residuals.largest_px2 / area;
  if (!(chance < 1)) return false;
  const double log_chance = std::log(std::max(chance, 1e-300));
  // So small that no count of poses and of sets (fewer than 4 n^3 and 2^n n) outweighs it.
  if ((k - 3) * log_chance < -(5 + 4 * std::log(n) + n) - 5) return true;
  const double log_tests = std::log(4.0) + log_choices(n, 3) + log_choices(n, k) + std::log(n);
  return log_tests + (k - 3) * log_chance < std::log(kChanceOfNonsense);
}

/// Whether the solver has answered every question, and the target has no mirror pose to look for.
bool is_all_said(const PoseProblem& problem, const PoseEstimate& estimate) {
  if (!estimate.residual_rms_px || !estimate.diagnosis) return false;
  const Diagnosis& said = *estimate.diagnosis;
  return said.is_test_failed && said.is_significant && said.is_ambiguous &&
         problem.points_in_target.size() > kMinimumPosePoints &&
         is_clearly_solid(problem.points_in_target);
}

}  // namespace

void judge(const PoseProblem& problem, PoseEstimate& estimate) {
  if (is_all_said(problem, estimate)) return;
  const Residuals residuals = residuals_of(problem, estimate);
  if (residuals.kept == 0) return;  // an M-estimator that calls all points outliers
  if (!estimate.residual_rms_px) {
    estimate.residual_rms_px =
        std::sqrt(residuals.squares / (2 * static_cast<double>(residuals.kept)));
  }
  if (!estimate.diagnosis) estimate.diagnosis.emplace();
  Diagnosis& diagnosis = *estimate.diagnosis;
  if (!diagnosis.is_test_failed) diagnosis.is_test_failed = !residuals.look_like_noise();
  if (!diagnosis.is_significant) diagnosis.is_significant = is_significant(problem, residuals);
  if (diagnosis.is_ambiguous.value_or(false)) return;
  diagnosis.is_ambiguous = false;
  if (residuals.kept < kMinimumPosePointsFromInitial) return;
  if (residuals.kept > 3 && is_clearly_solid(problem.points_in_target)) return;
  if (const std::optional<Pose> rival = rival_of(problem, estimate)) {
    diagnosis.is_ambiguous = true;
    estimate.second_cam_from_target = rival;
  }
}

}  // namespace sightline::entry
