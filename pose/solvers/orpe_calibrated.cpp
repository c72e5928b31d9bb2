// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// ORPE (pose/solvers/orpe.cpp) with its two weak places mended: rho comes from a stated false-alarm
// rate instead of a guess, and the tests run outward, so that one outlier does not hide behind
// another.
//
//   1. M_0 = min max_i f_i on all n points. For j = 1 .. k: remove the point of the largest
//      multiplier; M_j is the minimax of the n - j points that are left.
//   2. For j = k .. 1: if Lambda_j = M_{j-1} / M_j >= rho_j, stop: the first j points removed are
//      the outliers. Where the noise is known: if M_{j-1} > sigma_px^2 q_{j-1}. (If even M_k is,
//      some outlier was not found: the diagnosis says is_test_failed, and Lambda decides.)
//   3. The pose is that of least squares on what is left.
//
// rho_j is the quantile of Lambda for n - j + 1 points without outliers at a part of
// OutlierOptions::false_alarm_rate that halves with every further removal; q_j that of M for n - j
// points at the whole rate (pose/minimax_null.h). About that rate of the problems without outliers
// loses a point.
//
// Lambda and step 3's removal are those of Zhao, Zhang, Zuo, Xu (2009), section 3; testing outward
// from the smallest set is B. Rosner's: "Percentage points for a generalized ESD many-outlier
// procedure", Technometrics 25(2), 1983.
//
// Needs four points that are not collinear, or three with an initial pose. k is fewer than half of
// the points, or OutlierOptions::max_removed, and leaves at least two redundant coordinates,
// 2 (n - k) - 6 >= 2; it ends early where the points that are left would not determine the pose. Of
// the two mirror starts of a plane both are carried along, and the lower maximum counts at each
// step. kDegenerate when sigma_px is negative or not finite. Covariances of pixels are ignored.
//
// Where it falls short: the points are removed one by one, and with two outliers of eight the point
// of the largest multiplier is one of them in 75 to 95 % only.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "pose/fit_points.h"
#include "pose/minimax.h"
#include "pose/minimax_null.h"
#include "pose/removal_limits.h"
#include "pose/reprojection.h"
#include "pose/solvers/solvers.h"
#include "pose/starts.h"

namespace sightline {
namespace {

/// The minimax of what is left at one step of the removal.
struct Stage {
  std::vector<int> kept;
  double largest_px2 = 0;
  std::size_t binding = 0;  ///< position in kept of the point to remove next
  Pose cam_from_centred;
};

/// The minimax of a stage from where each branch stands, which it moves. Branches that fail are
/// dropped. None when all are.
std::optional<Stage> stage_of(const Correspondences& c, std::vector<int> kept,
                              std::vector<Pose>& branches, int& iterations) {
  const FitPoints points = {c, kept, {}};
  std::optional<Stage> stage;
  std::vector<Pose> moved;
  for (const Pose& branch : branches) {
    const Minimax fit = minimax_from(points, branch, {.relative_gap = 1e-7});
    iterations += fit.iterations;
    if (fit.status != PoseStatus::kOk || !unit_covariance(points, fit.cam_from_centred)) continue;
    moved.push_back(fit.cam_from_centred);
    if (stage && !(fit.largest_px2 < stage->largest_px2)) continue;
    stage = Stage{{}, fit.largest_px2, fit.most_binding(), fit.cam_from_centred};
  }
  if (stage) stage->kept = std::move(kept);
  branches = std::move(moved);
  return stage;
}

/// Lambda; one where there is nothing to explain.
double residual_ratio(const Stage& before, const Stage& after) {
  if (!(before.largest_px2 > 0)) return 1;
  return before.largest_px2 / std::max(after.largest_px2, std::numeric_limits<double>::min());
}

/// How many of the stages' removals stand by the ratios of their residuals.
std::size_t test_ratios(const std::vector<Stage>& stages, double false_alarm_rate) {
  const std::size_t most = stages.size() - 1;
  for (std::size_t j = most; j > 0; --j) {
    // 2^-j of the rate, over the sum of such parts.
    const double part =
        std::exp2(-static_cast<double>(j)) / (1 - std::exp2(-static_cast<double>(most)));
    const double rho = minimax_ratio_quantile(stages[j - 1].kept.size(), part * false_alarm_rate);
    if (residual_ratio(stages[j - 1], stages[j]) >= rho) return j;
  }
  return 0;
}

/// How many of the stages' removals stand by the size of their residuals. None where even the last
/// residual is no noise.
std::optional<std::size_t> test_residuals(const std::vector<Stage>& stages, double sigma_px,
                                          double false_alarm_rate) {
  for (std::size_t j = stages.size(); j > 0; --j) {
    const Stage& stage = stages[j - 1];
    const double noise_px2 =
        sigma_px * sigma_px * minimax_quantile(stage.kept.size(), false_alarm_rate);
    if (stage.largest_px2 <= std::max(noise_px2, kZeroResidualPx2)) continue;
    return j < stages.size() ? std::optional(j) : std::nullopt;
  }
  return 0;
}

}  // namespace

PoseEstimate solve_orpe_calibrated(const PoseProblem& problem, const SolverOptions& options) {
  PoseEstimate estimate;
  const PreparedProblem prepared = prepare(problem);
  estimate.status = prepared.status;
  if (estimate.status != PoseStatus::kOk) return estimate;
  const Correspondences& c = prepared.correspondences;

  std::vector<Pose> branches;
  estimate.status = PoseStatus::kDegenerate;
  if (!std::isfinite(problem.sigma_px) || problem.sigma_px < 0) return estimate;
  for (const Pose& start : starting_poses(c, problem.initial_cam_from_target)) {
    const LeastSquares begin = least_squares(c, {&start, 1}, options.lspe);
    estimate.iterations += begin.iterations;
    if (branches.empty()) estimate.status = begin.status;
    // Where least squares stopped is a start as good as another.
    const bool is_start = begin.status == PoseStatus::kOk || begin.status == PoseStatus::kDiverged;
    if (is_start) branches.push_back(begin.cam_from_centred);
  }
  if (branches.empty()) return estimate;

  std::vector<int> all(c.size());
  std::iota(all.begin(), all.end(), 0);
  std::optional<Stage> stage = stage_of(c, all, branches, estimate.iterations);
  if (!stage) {
    estimate.status = PoseStatus::kDiverged;
    return estimate;
  }
  const std::size_t limit = minority_limit(options.outliers, c.size());
  std::vector<Stage> stages = {std::move(*stage)};
  while (stages.size() <= limit) {
    std::vector<int> kept = stages.back().kept;
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(stages.back().binding));
    stage = stage_of(c, std::move(kept), branches, estimate.iterations);
    if (!stage) break;
    stages.push_back(std::move(*stage));
  }

  const double rate = options.outliers.false_alarm_rate;
  std::optional<std::size_t> by_residual;
  if (problem.sigma_px > 0) by_residual = test_residuals(stages, problem.sigma_px, rate);
  const std::size_t removals = by_residual ? *by_residual : test_ratios(stages, rate);
  const Stage& last = stages[removals];
  Diagnosis& diagnosis = estimate.diagnosis.emplace();
  diagnosis.is_removal_limit_reached = removals > 0 && removals == limit;
  if (problem.sigma_px > 0) diagnosis.is_test_failed = !by_residual;
  std::set_difference(all.begin(), all.end(), last.kept.begin(), last.kept.end(),
                      std::back_inserter(estimate.removed));
  return with_least_squares(std::move(estimate), {c, last.kept, {}}, last.cam_from_centred,
                            options.lspe);
}

}  // namespace sightline
