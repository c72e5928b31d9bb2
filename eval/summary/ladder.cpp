// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/ladder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>

#include <fmt/format.h>

#include "eval/records/caps.h"
#include "eval/summary/cells.h"
#include "pose/angles.h"
#include "pose/bounds.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

constexpr int kDraws = 4096;  // of a bound's errors: their mean logarithm is then right to 1 %
constexpr double kLeastError = 1e-12;  // stands for none at all, whose logarithm is not finite

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Normal numbers, the same for every bound.
const Eigen::Matrix<double, 6, Eigen::Dynamic>& unit_draws() {
  static const Eigen::Matrix<double, 6, Eigen::Dynamic> draws = [] {
    Eigen::Matrix<double, 6, Eigen::Dynamic> all(6, kDraws);
    RandomStream stream(0, "ladder", 0);
    for (int k = 0; k < kDraws; ++k) {
      for (int i = 0; i < 6; ++i) all(i, k) = stream.normal();
    }
    return all;
  }();
  return draws;
}

double log_of(double error, double cap) {
  return std::log(std::clamp(error, kLeastError, cap));
}

std::array<double, 2> log_errors_of(double geodesic_deg, double t_error_percent) {
  return {log_of(geodesic_deg, kAngleCapDeg), log_of(t_error_percent, kTranslationCapPercent)};
}

// Of errors drawn from a covariance; none where it is none.
std::optional<std::array<double, 2>> mean_log_errors(const Matrix6& covariance, const Pose& pose) {
  const std::optional<Matrix6> root = root_of(covariance);
  if (!root) return std::nullopt;
  const Eigen::Matrix<double, 6, Eigen::Dynamic> errors = *root * unit_draws();
  // T_error is the RMS of three components over the distance.
  const double percent_per_m = 100 / std::numbers::sqrt3 / pose.translation.norm();
  std::array<double, 2> sum = {0, 0};
  for (int k = 0; k < kDraws; ++k) {
    const std::array<double, 2> drawn = log_errors_of(
        errors.col(k).head<3>().norm() / kDegree, errors.col(k).tail<3>().norm() * percent_per_m);
    for (size_t i = 0; i < 2; ++i) sum[i] += drawn[i] / kDraws;
  }
  return sum;
}

Measured factor_of(const ErrorStatistics& growth, uint64_t seed, const std::string& stream) {
  const Measured logarithm = growth.mean_of(seed, stream);
  return {std::exp(logarithm.value), {std::exp(logarithm.ci95[0]), std::exp(logarithm.ci95[1])}};
}

}  // namespace

Ladder::Ladder(const Study& study) : seed_(study.seed) {
  const std::vector<std::string> solvers = study.solver_names();
  const auto has = [&](const std::string& name) {
    return std::find(solvers.begin(), solvers.end(), name) != solvers.end();
  };
  if (!has("image_bound")) return;
  const std::string lead = lead_solver(study);
  rungs_ = {{"image_bound", "image", true},
            {"outline_bound", "outline alone", true},
            {"", "points found", true}};
  add_step(0, 1);
  add_step(1, 2);
  size_t last = 2;
  // A perfect removal's rung: the solver itself given the true inliers, or least squares on them.
  const std::string on_inliers = has(lead + "/inliers") ? lead + "/inliers" : "oracle";
  if (has(on_inliers)) {
    rungs_.push_back({on_inliers, on_inliers == "oracle" ? "oracle, on the inliers" : on_inliers});
    add_step(last, rungs_.size() - 1);
    last = rungs_.size() - 1;
  }
  if (has(lead)) {
    rungs_.push_back({lead, lead});
    add_step(last, rungs_.size() - 1);
    add_step(0, rungs_.size() - 1);
  }
  for (size_t bound = 0; bound < 2; ++bound) {
    const std::string name = bound == 0 ? "registration_image" : "registration_outline";
    if (!has(name) || name == lead) continue;
    rungs_.push_back({name, name});
    add_step(bound, rungs_.size() - 1);
  }
}

void Ladder::add_step(size_t from, size_t to) {
  constexpr double kNoCap = std::numeric_limits<double>::max();
  steps_.push_back({from, to, {ErrorStatistics(kNoCap), ErrorStatistics(kNoCap)}});
}

Ladder::LogErrors Ladder::log_errors(const Rung& rung, const TrialRecord& trial,
                                     const std::optional<TrialBound>& points) const {
  if (rung.name.empty()) {
    if (!points) return std::nullopt;
    return mean_log_errors(points->covariance, trial.true_cam_from_target);
  }
  const EstimateRecord* const estimate = find_estimate(trial, rung.name);
  const bool has_pose = estimate != nullptr && estimate->is_ok();
  if (rung.is_bound) {
    if (!has_pose || !estimate->covariance) return std::nullopt;
    return mean_log_errors(*estimate->covariance, trial.true_cam_from_target);
  }
  if (!has_pose) return log_errors_of(kAngleCapDeg, kTranslationCapPercent);
  return log_errors_of(estimate->geodesic_deg, estimate->t_error_percent);
}

void Ladder::add(const TrialRecord& trial, const std::optional<TrialBound>& points) {
  std::vector<LogErrors> errors;
  for (const Rung& rung : rungs_) errors.push_back(log_errors(rung, trial, points));
  for (Step& step : steps_) {
    const LogErrors& from = errors[step.from];
    const LogErrors& to = errors[step.to];
    if (!from || !to) continue;
    for (size_t i = 0; i < 2; ++i) step.growth[i].add((*to)[i] - (*from)[i]);
  }
}

std::vector<LadderStep> Ladder::steps() const {
  std::vector<LadderStep> steps;
  for (const Step& step : steps_) {
    const Rung& from = rungs_[step.from];
    const Rung& to = rungs_[step.to];
    const std::string stream = fmt::format("ladder/{}/{}", from.label, to.label);
    steps.push_back({from.label, to.label, step.growth[0].count(),
                     factor_of(step.growth[0], seed_, stream + "/geodesic"),
                     factor_of(step.growth[1], seed_, stream + "/translation")});
  }
  return steps;
}

}  // namespace sightline
