// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/pose_cell.h"

#include <algorithm>

#include "eval/statistics/rate_interval.h"

namespace sightline {
namespace {

constexpr double kChiSquared6At95 = 12.591587243743977;  // R: qchisq(0.95, 6)

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Over nothing there is no ratio.
void add_ratio(double error, double reference, ErrorStatistics& ratios) {
  if (reference > 0) ratios.add(error / reference);
}

double capped_geodesic_deg(const EstimateRecord* estimate) {
  return estimate != nullptr ? std::min(estimate->geodesic_deg, kAngleCapDeg) : kAngleCapDeg;
}

}  // namespace

const EstimateRecord* pose_of(const TrialRecord& trial, std::string_view solver) {
  const EstimateRecord* const estimate = find_estimate(trial, solver);
  return estimate != nullptr && estimate->is_ok() ? estimate : nullptr;
}

void PoseCell::add(const TrialRecord& trial, const TrialReference& reference) {
  const EstimateRecord* const estimate = pose_of(trial, solver_);
  if (estimate != nullptr) {
    add_pose(*estimate);
  } else {
    ++failures_;
    missed_outliers_ += reference.outliers;
    errors_.add_failure();
  }
  is_near_lock_ = is_near_lock_ || is_near_gimbal_lock(trial.true_cam_from_target.rotation);
  const double geodesic_deg = capped_geodesic_deg(estimate);
  const double ratio_of = estimate != nullptr ? estimate->geodesic_deg : kInfinity;
  if (reference.oracle != nullptr) {
    to_oracle_.add(geodesic_deg, capped_geodesic_deg(reference.oracle));
    add_ratio(ratio_of, reference.oracle->geodesic_deg, oracle_ratios_);
    theta_beside_oracle_.add(estimate != nullptr ? estimate->theta_error_deg : kInfinity);
    t_beside_oracle_.add(estimate != nullptr ? estimate->t_error_percent : kInfinity);
  }
  if (reference.bound) {
    to_bound_.add(geodesic_deg, reference.bound->geodesic_deg);
    add_ratio(ratio_of, reference.bound->geodesic_deg, bound_ratios_);
  }
}

void PoseCell::add_pose(const EstimateRecord& estimate) {
  errors_.add(estimate);
  false_removals_ += estimate.false_removals;
  missed_outliers_ += estimate.missed_outliers;
  exact_ += estimate.false_removals == 0 && estimate.missed_outliers == 0;
  if (!estimate.nees) return;
  nees_.add(*estimate.nees);
  nees_covered_ += *estimate.nees <= kChiSquared6At95;
}

NeesSummary PoseCell::nees_summary() const {
  NeesSummary nees;
  nees.trials = nees_.count();
  nees.mean = nees_.mean();
  nees.median = nees_.median();
  if (nees.trials > 0) {
    nees.coverage95 = static_cast<double>(nees_covered_) / static_cast<double>(nees.trials);
  }
  nees.coverage95_ci95 = rate_interval(nees_covered_, nees.trials);
  return nees;
}

CellSummary PoseCell::summary(const Study& study, int trials) const {
  CellSummary cell;
  cell.set_errors(errors_.summary(study, condition_, solver_));
  cell.condition = condition_;
  cell.solver = solver_;
  cell.trials = trials;
  cell.failures = failures_;
  cell.failure_rate_ci95 = rate_interval(failures_, trials);
  if (is_near_lock_) drop_intervals_of_angles(cell);
  cell.ratio_to_oracle = to_oracle_.value();
  cell.ratio_to_oracle_median = oracle_ratios_.median();
  cell.oracle_trials = static_cast<int>(theta_beside_oracle_.count());
  cell.theta_beside_oracle_deg = theta_beside_oracle_.mean();
  cell.t_beside_oracle_percent = t_beside_oracle_.mean();
  cell.ratio_to_bound = to_bound_.value();
  cell.ratio_to_bound_median = bound_ratios_.median();
  cell.nees = nees_summary();
  if (trials == 0) return cell;
  cell.false_removals = static_cast<double>(false_removals_) / trials;
  cell.missed_outliers = static_cast<double>(missed_outliers_) / trials;
  cell.exact_set_rate = static_cast<double>(exact_) / trials;
  cell.exact_set_rate_ci95 = rate_interval(exact_, trials);
  return cell;
}

}  // namespace sightline
