// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/summary.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "eval/statistics/rate_interval.h"
#include "eval/summary/ladder.h"
#include "eval/summary/pose_cell.h"
#include "eval/summary/repeats.h"
#include "eval/summary/trial_bounds.h"

namespace sightline {
namespace {

constexpr std::string_view kOracle = "oracle";

// ---- Studies that estimate poses ----

// A condition: what its images gave, and its solvers.
struct PoseCondition {
  int trials = 0;
  Repeats repeats;
  int64_t found = 0;
  int64_t outliers = 0;
  MeanSquare inlier_error_px;  // of one coordinate
  double bound_theta_deg = 0;
  double bound_t_percent = 0;
  MeanSquare bound_geodesic_deg;
  std::vector<PoseCell> cells;  // in the study's order of solvers

  void add(const ObservationRecord& observation) {
    found += observation.is_found();
    outliers += observation.is_outlier;
    if (!observation.is_found() || observation.is_outlier) return;
    inlier_error_px.add(observation.error_px / std::numbers::sqrt2);
  }
  void add(const TrialBound& bound) {
    bound_theta_deg += bound.theta_deg;
    bound_t_percent += bound.t_percent;
    bound_geodesic_deg.add(bound.geodesic_deg);
  }
  CellObservations observations(int condition) const;
};

CellObservations PoseCondition::observations(int condition) const {
  CellObservations cell;
  cell.condition = condition;
  cell.trials = trials;
  cell.repeated = repeats.count();
  cell.inlier_rms_px = inlier_error_px.root();
  if (trials > 0) {
    cell.found = static_cast<double>(found) / trials;
    cell.outliers = static_cast<double>(outliers) / trials;
  }
  const int bounds = bound_geodesic_deg.count;
  cell.bound_theta_deg = bounds > 0 ? bound_theta_deg / bounds : kNoNumber;
  cell.bound_t_percent = bounds > 0 ? bound_t_percent / bounds : kNoNumber;
  cell.bound_geodesic_deg = bound_geodesic_deg.root();
  return cell;
}

// Takes trials in the order of their numbers, so that no sum depends on shards.
class PoseSummariser {
 public:
  explicit PoseSummariser(const Study& study)
      : study_(study),
        bounds_(study),
        features_(study),
        ladder_(study),
        conditions_(study.conditions.size()) {
    const std::vector<std::string> solvers = study.solver_names();
    for (size_t i = 0; i < conditions_.size(); ++i) {
      for (const std::string& solver : solvers) {
        conditions_[i].cells.emplace_back(static_cast<int>(i), solver);
      }
    }
  }

  // What the images gave.
  void observe(const TrialRecord& trial) {
    PoseCondition& condition = condition_of(trial);
    ++condition.trials;
    condition.repeats.add(trial);
    for (const ObservationRecord& observation : trial.observations()) condition.add(observation);
    features_.add(trial);
  }

  // The bound of an image study needs the noise of its features, which is known when all trials
  // were observed.
  void take_noise_as_observed() {
    for (int i = 0; i < static_cast<int>(conditions_.size()); ++i) {
      bounds_.set_noise_px(i, features_.inlier_rms_px(i));
    }
  }

  // What the solvers made of it.
  void judge(const TrialRecord& trial) {
    PoseCondition& condition = condition_of(trial);
    TrialReference reference;
    reference.outliers =
        static_cast<int>(std::count_if(trial.observations().begin(), trial.observations().end(),
                                       [](const ObservationRecord& o) { return o.is_outlier; }));
    if (!bounds_.is_noiseless(trial.condition)) reference.oracle = pose_of(trial, kOracle);
    reference.bound = bounds_.of(trial);
    if (reference.bound) condition.add(*reference.bound);
    for (PoseCell& cell : condition.cells) cell.add(trial, reference);
    ladder_.add(trial, reference.bound);
  }

  Summary finish() const {
    Summary summary;
    for (size_t i = 0; i < conditions_.size(); ++i) {
      const PoseCondition& condition = conditions_[i];
      for (const PoseCell& cell : condition.cells) {
        summary.cells.push_back(cell.summary(study_, condition.trials));
      }
      summary.observations.push_back(condition.observations(static_cast<int>(i)));
    }
    summary.features = features_.summaries();
    summary.ladder = ladder_.steps();
    return summary;
  }

  FeatureStatistics&& take_features() && { return std::move(features_); }

 private:
  PoseCondition& condition_of(const TrialRecord& trial) {
    return conditions_.at(static_cast<size_t>(trial.condition));
  }

  const Study& study_;
  TrialBounds bounds_;
  FeatureStatistics features_;
  Ladder ladder_;
  std::vector<PoseCondition> conditions_;
};

Summary summarise_images(const Study& study, const TrialSource& trials) {
  PoseSummariser summariser(study);
  trials([&](const TrialRecord& trial) { summariser.observe(trial); });
  summariser.take_noise_as_observed();
  trials([&](const TrialRecord& trial) { summariser.judge(trial); });
  Summary summary = summariser.finish();
  summary.extraction = std::move(summariser).take_features();
  return summary;
}

Summary summarise_numeric(const Study& study, const TrialSource& trials) {
  PoseSummariser summariser(study);
  trials([&](const TrialRecord& trial) {
    summariser.observe(trial);
    summariser.judge(trial);
  });
  return summariser.finish();
}

// ---- Orientation studies ----

// One method in one condition, trial by trial.
struct MethodCell {
  std::string method;
  int failures = 0;
  int failed_copies = 0;
  CellErrorStatistics errors;
  bool is_near_lock = false;

  void add(const TrialRecord& trial) {
    is_near_lock = is_near_lock || is_near_gimbal_lock(trial.true_cam_from_target.rotation);
    for (const OrientationRecord& orientation : trial.orientations()) {
      if (orientation.method != method) continue;
      failures += orientation.failures > 0;
      failed_copies += orientation.failures;
      errors.add(orientation);
      return;
    }
  }
  CellSummary summary(const Study& study, int condition, int trials) const {
    CellSummary cell;
    cell.set_errors(errors.summary(study, condition, method));
    if (is_near_lock) drop_intervals_of_angles(cell);
    cell.condition = condition;
    cell.solver = method;
    cell.trials = trials;
    cell.failures = failures;
    cell.failed_copies = failed_copies;
    cell.failure_rate_ci95 = rate_interval(failures, trials);
    return cell;
  }
};

struct MethodCondition {
  int trials = 0;
  Repeats repeats;
  std::vector<MethodCell> cells;  // in the study's order of methods

  void add(const TrialRecord& trial) {
    ++trials;
    repeats.add(trial);
    for (MethodCell& cell : cells) cell.add(trial);
  }
};

Summary summarise_orientations(const Study& study, const TrialSource& trials) {
  MethodCondition empty;
  for (const std::string& method : study.solver_names()) empty.cells.emplace_back().method = method;
  std::vector<MethodCondition> conditions(study.conditions.size(), empty);
  trials([&](const TrialRecord& trial) {
    conditions.at(static_cast<size_t>(trial.condition)).add(trial);
  });
  Summary summary;
  for (int i = 0; i < static_cast<int>(conditions.size()); ++i) {
    const MethodCondition& condition = conditions[static_cast<size_t>(i)];
    for (const MethodCell& cell : condition.cells) {
      summary.cells.push_back(cell.summary(study, i, condition.trials));
    }
    CellObservations& observations = summary.observations.emplace_back();
    observations.condition = i;
    observations.trials = condition.trials;
    observations.repeated = condition.repeats.count();
  }
  return summary;
}

}  // namespace

TrialSource in_order(std::span<const TrialRecord> trials) {
  std::vector<const TrialRecord*> sorted;
  for (const TrialRecord& trial : trials) sorted.push_back(&trial);
  std::sort(sorted.begin(), sorted.end(),
            [](const TrialRecord* a, const TrialRecord* b) { return a->trial < b->trial; });
  return [sorted = std::move(sorted)](const TrialVisitor& visit) {
    for (const TrialRecord* trial : sorted) visit(*trial);
  };
}

Summary summarise(const Study& study, const TrialSource& trials) {
  if (study.images() != nullptr) return summarise_images(study, trials);
  if (study.numeric() != nullptr) return summarise_numeric(study, trials);
  return summarise_orientations(study, trials);
}

Summary summarise(const Study& study, std::span<const TrialRecord> trials) {
  return summarise(study, in_order(trials));
}

// Degrees and percent: exact data leave 1e-9 and less, the finest images 1e-3.
constexpr double kRoundingAlone = 1e-6;

std::optional<int64_t> trials_needed(const CellSummary& cell, double target) {
  std::optional<int64_t> most;
  const bool has_theta = !std::isnan(cell.theta_error_deg.mean_ci95[0]);
  const ErrorSummary& angle = has_theta ? cell.theta_error_deg : cell.geodesic_deg;
  for (const ErrorSummary* error : {&angle, &cell.t_error_percent}) {
    if (error->mean < kRoundingAlone) continue;
    const auto needed = trials_for(target, cell.trials, error->mean, error->resampled_mean_ci95);
    if (needed && (!most || *needed > *most)) most = needed;
  }
  return most;
}

}  // namespace sightline
