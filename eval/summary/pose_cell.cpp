// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/pose_cell.h"

#include <algorithm>

#include "eval/records/caps.h"

namespace sightline {
namespace {

constexpr double kChiSquared6At95 = 12.591587243743977;  // R: qchisq(0.95, 6)

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
  const double geodesic_deg = capped_geodesic_deg(estimate);
  if (reference.oracle != nullptr) {
    to_oracle_.add(geodesic_deg, capped_geodesic_deg(reference.oracle));
  }
  if (reference.bound) to_bound_.add(geodesic_deg, reference.bound->geodesic_deg);
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

NeesSummary PoseCell::nees_summary(const Study& study) const {
  const ErrorSummary errors =
      nees_.summary(study.seed, bootstrap_stream(study, condition_, solver_, "nees"));
  NeesSummary nees;
  nees.trials = nees_.count();
  nees.mean = errors.mean;
  nees.mean_ci95 = errors.mean_ci95;
  if (nees.trials > 0) {
    nees.coverage95 = static_cast<double>(nees_covered_) / static_cast<double>(nees.trials);
  }
  nees.coverage95_ci95 = wilson_interval(nees_covered_, nees.trials);
  return nees;
}

CellSummary PoseCell::summary(const Study& study, int trials) const {
  CellSummary cell;
  cell.set_errors(errors_.summary(study, condition_, solver_));
  cell.condition = condition_;
  cell.solver = solver_;
  cell.trials = trials;
  cell.failures = failures_;
  cell.failure_rate_ci95 = wilson_interval(failures_, trials);
  cell.ratio_to_oracle = to_oracle_.value();
  cell.ratio_to_oracle_ci95 = to_oracle_.ci95();
  cell.ratio_to_bound = to_bound_.value();
  cell.ratio_to_bound_ci95 = to_bound_.ci95();
  cell.nees = nees_summary(study);
  if (trials == 0) return cell;
  cell.false_removals = static_cast<double>(false_removals_) / trials;
  cell.missed_outliers = static_cast<double>(missed_outliers_) / trials;
  cell.exact_set_rate = static_cast<double>(exact_) / trials;
  cell.exact_set_rate_ci95 = wilson_interval(exact_, trials);
  return cell;
}

}  // namespace sightline
