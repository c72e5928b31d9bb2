// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/summary.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <string_view>
#include <unordered_set>

#include <fmt/format.h>

#include "pose/bounds.h"

namespace sightline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::string_view kOracle = "oracle";
// Stands for the noise of a feature that showed none, so that its information is finite.
constexpr double kLeastNoisePx = 1e-3;
constexpr double kChiSquared6At95 = 12.591587243743977;  // R: qchisq(0.95, 6)

// A sum of squares that knows how many it holds.
struct MeanSquare {
  double sum = 0;
  int count = 0;

  void add(double value) {
    sum += value * value;
    ++count;
  }
  double root() const { return count > 0 ? std::sqrt(sum / count) : kNoNumber; }
};

int outliers_in(const TrialRecord& trial) {
  return static_cast<int>(std::count_if(trial.observations().begin(), trial.observations().end(),
                                        [](const ObservationRecord& o) { return o.is_outlier; }));
}

// The solver's pose of a trial; null when it failed or is not there.
const EstimateRecord* pose_of(const TrialRecord& trial, std::string_view solver) {
  const EstimateRecord* const estimate = find_estimate(trial, solver);
  return estimate != nullptr && estimate->is_ok() ? estimate : nullptr;
}

// The bound of one trial, in the units of errors and capped like them.
struct TrialBound {
  double theta_deg = 0;
  double t_percent = 0;
  double geodesic_deg = 0;
};

// Where the target has its features, by name; empty for a study without a target.
using Positions = std::map<std::string, Eigen::Vector3d>;

Positions positions_of(const Study& study) {
  Positions positions;
  if (study.target == nullptr) return positions;
  for (const TargetFeature& feature : study.target->features) {
    positions.emplace(feature.name, feature.position_m);
  }
  return positions;
}

// None for a trial whose inliers do not determine a pose. A feature that the target does not have
// (any more: stored trials outlive the target's file) tells nothing.
std::optional<TrialBound> bound_of(const Study& study, const Positions& positions,
                                   const TrialRecord& trial,
                                   const std::map<std::string, double>& noise_px) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Matrix2d> covariances_px2;
  for (const ObservationRecord& o : trial.observations()) {
    const auto position = positions.find(o.feature);
    if (!o.is_found() || o.is_outlier || position == positions.end()) continue;
    points.push_back(position->second);
    const double sd_px = std::max(noise_px.at(o.feature), kLeastNoisePx);
    covariances_px2.push_back(sd_px * sd_px * Eigen::Matrix2d::Identity());
  }
  const auto bound = cramer_rao_bound(study.camera_of(trial.condition, trial.trial), points,
                                      trial.true_cam_from_target, covariances_px2);
  if (!bound) return std::nullopt;
  constexpr double kDegree = std::numbers::pi / 180;
  return TrialBound{std::min(bound->attitude_rms_rad / kDegree, kAngleCapDeg),
                    std::min(100 * bound->translation_rms, kTranslationCapPercent),
                    std::min(bound->geodesic_rms_rad / kDegree, kAngleCapDeg)};
}

// A numeric study's cell without noise has no bound, and exact solvers err by rounding alone, of
// which ratios say nothing.
bool is_noiseless(const Study& study, int condition) {
  return study.kind == StudyKind::kNumeric && study.conditions[condition].noise_sd == 0;
}

// A solver in a condition, trial by trial.
struct CellAccumulator {
  CellSummary cell;
  ErrorStatistics theta_error_deg{kAngleCapDeg};
  ErrorStatistics t_error_percent{kTranslationCapPercent};
  ErrorStatistics geodesic_deg{kAngleCapDeg};
  ErrorStatistics angle_error_deg{kAngleCapDeg};  // as the next, of an orientation study
  ErrorStatistics time_ns{kInfinity};
  int64_t false_removals = 0;
  int64_t missed_outliers = 0;
  int64_t exact = 0;
  RmsRatio to_oracle;
  RmsRatio to_bound;
  ErrorStatistics nees{kInfinity};
  int64_t nees_covered = 0;
};

// A feature in a condition.
struct FeatureAccumulator {
  FeatureSummary summary;
  MeanSquare inlier_error_px;  // of one coordinate
  ErrorStatistics error_px{kInfinity};
};

// A number that trials share if they are the same draw, and almost surely only then.
class Fingerprint {
 public:
  explicit Fingerprint(const TrialRecord& trial) {
    add(trial.true_cam_from_target);
    if (const auto* pose_trial = std::get_if<PoseTrial>(&trial.kind)) {
      add(pose_trial->prior_cam_from_target);
    }
    for (const ObservationRecord& o : trial.observations()) {
      add(o.is_found());
      add(o.pixel.x());
      add(o.pixel.y());
    }
    for (const OrientationRecord& o : trial.orientations()) add(o.geodesic_deg);
  }
  uint64_t value() const { return value_; }

 private:
  void add(double number) {
    // FNV-1a over words, with a shift as the high bits of doubles hold most.
    value_ = (value_ ^ std::bit_cast<uint64_t>(number)) * 0x100000001b3;
    value_ ^= value_ >> 32;
  }
  void add(const Pose& pose) {
    for (const double element : pose.rotation.reshaped()) add(element);
    for (const double element : pose.translation) add(element);
  }

  uint64_t value_ = 0xcbf29ce484222325;
};

// Counts the trials that were there before, in memory that does not grow for ever.
class Repeats {
 public:
  void add(const TrialRecord& trial) {
    if (trial.observations().empty() && trial.orientations().empty()) return;  // nothing was drawn
    const uint64_t fingerprint = Fingerprint(trial).value();
    if (seen_.contains(fingerprint)) {
      ++count_;
    } else if (seen_.size() < ErrorStatistics::kMostValuesKept) {
      seen_.insert(fingerprint);
    }
  }
  int count() const { return count_; }

 private:
  std::unordered_set<uint64_t> seen_;
  int count_ = 0;
};

// A condition: what its images gave, and its solvers.
struct ConditionAccumulator {
  int trials = 0;
  Repeats repeats;
  int64_t found = 0;
  int64_t outliers = 0;
  MeanSquare inlier_error_px;
  std::vector<FeatureAccumulator>
      features;  // in the order in which they come, which is the study's
  double bound_theta_deg = 0;
  double bound_t_percent = 0;
  MeanSquare bound_geodesic_deg;
  std::vector<CellAccumulator> cells;  // in the study's order of solvers
};

double capped_geodesic_deg(const EstimateRecord* estimate) {
  return estimate != nullptr ? std::min(estimate->geodesic_deg, kAngleCapDeg) : kAngleCapDeg;
}

const OrientationRecord* find_orientation(const TrialRecord& trial, std::string_view method) {
  for (const OrientationRecord& orientation : trial.orientations()) {
    if (orientation.method == method) return &orientation;
  }
  return nullptr;
}

// Takes trials in the order of their numbers, so that no sum depends on shards.
class Summariser {
 public:
  explicit Summariser(const Study& study)
      : study_(study), positions_(positions_of(study)), conditions_(study.conditions.size()) {
    const std::vector<std::string> solvers = study.solver_names();
    for (size_t i = 0; i < conditions_.size(); ++i) {
      for (const std::string& solver : solvers) {
        CellSummary& cell = conditions_[i].cells.emplace_back().cell;
        cell.condition = static_cast<int>(i);
        cell.solver = solver;
      }
    }
  }

  // What the images gave. In a study with images the noise of its features, which a bound needs, is
  // known when all trials have been through here.
  void observe(const TrialRecord& trial) {
    ConditionAccumulator& condition = conditions_.at(static_cast<size_t>(trial.condition));
    ++condition.trials;
    condition.repeats.add(trial);
    for (size_t i = 0; i < trial.observations().size(); ++i) {
      const ObservationRecord& o = trial.observations()[i];
      FeatureAccumulator& feature = feature_of(condition, o.feature, i, trial.condition);
      condition.found += o.is_found();
      condition.outliers += o.is_outlier;
      feature.summary.visible += o.is_visible;
      feature.summary.outliers += o.is_outlier;
      if (!o.is_found()) continue;
      ++feature.summary.found;
      feature.error_px.add(o.error_px);
      if (o.is_outlier) continue;
      condition.inlier_error_px.add(o.error_px / std::numbers::sqrt2);
      feature.inlier_error_px.add(o.error_px / std::numbers::sqrt2);
    }
  }

  // What the solvers made of it.
  void judge(const TrialRecord& trial) {
    ConditionAccumulator& condition = conditions_.at(static_cast<size_t>(trial.condition));
    if (study_.kind == StudyKind::kOrientation) {
      for (CellAccumulator& cell : condition.cells) add_orientation(trial, cell);
      return;
    }
    const bool has_ratios = !is_noiseless(study_, trial.condition);
    const std::optional<TrialBound> bound = has_ratios ? bound_for(trial) : std::nullopt;
    if (bound) {
      condition.bound_theta_deg += bound->theta_deg;
      condition.bound_t_percent += bound->t_percent;
      condition.bound_geodesic_deg.add(bound->geodesic_deg);
    }
    const EstimateRecord* const oracle = has_ratios ? pose_of(trial, kOracle) : nullptr;
    const int outliers = outliers_in(trial);
    for (CellAccumulator& cell : condition.cells) {
      const EstimateRecord* const estimate = pose_of(trial, cell.cell.solver);
      add_estimate(estimate, outliers, cell);
      const double geodesic_deg = capped_geodesic_deg(estimate);
      if (oracle != nullptr) cell.to_oracle.add(geodesic_deg, capped_geodesic_deg(oracle));
      if (bound) cell.to_bound.add(geodesic_deg, bound->geodesic_deg);
    }
  }

  Summary finish() const {
    Summary summary;
    for (size_t i = 0; i < conditions_.size(); ++i) {
      const ConditionAccumulator& condition = conditions_[i];
      for (const CellAccumulator& cell : condition.cells) {
        summary.cells.push_back(finished_cell(cell, condition.trials));
      }
      summary.observations.push_back(finished_observations(condition, static_cast<int>(i)));
      for (const FeatureAccumulator& feature : condition.features) {
        FeatureSummary& finished = summary.features.emplace_back(feature.summary);
        finished.inlier_rms_px = feature.inlier_error_px.root();
        finished.median_px = feature.error_px.quantile(0.5);
      }
    }
    return summary;
  }

 private:
  // Every trial that was imaged has an observation of every feature, in the study's order.
  static FeatureAccumulator& feature_of(ConditionAccumulator& condition, const std::string& name,
                                        size_t guess, int condition_index) {
    std::vector<FeatureAccumulator>& features = condition.features;
    if (guess < features.size() && features[guess].summary.feature == name) return features[guess];
    for (FeatureAccumulator& feature : features) {
      if (feature.summary.feature == name) return feature;
    }
    FeatureAccumulator& feature = features.emplace_back();
    feature.summary.condition = condition_index;
    feature.summary.feature = name;
    return feature;
  }

  std::optional<TrialBound> bound_for(const TrialRecord& trial) const {
    const ConditionAccumulator& condition = conditions_.at(static_cast<size_t>(trial.condition));
    std::map<std::string, double> noise_px;
    for (const FeatureAccumulator& feature : condition.features) {
      noise_px[feature.summary.feature] =
          study_.kind == StudyKind::kNumeric
              ? study_.conditions[static_cast<size_t>(trial.condition)].noise_sd
              : feature.inlier_error_px.root();
    }
    return bound_of(study_, positions_, trial, noise_px);
  }

  static void add_estimate(const EstimateRecord* estimate, int outliers, CellAccumulator& cell) {
    if (estimate == nullptr) {
      ++cell.cell.failures;
      cell.missed_outliers += outliers;
      for (ErrorStatistics* error :
           {&cell.theta_error_deg, &cell.t_error_percent, &cell.geodesic_deg}) {
        error->add(kInfinity);
      }
      return;
    }
    cell.theta_error_deg.add(estimate->theta_error_deg);
    cell.t_error_percent.add(estimate->t_error_percent);
    cell.geodesic_deg.add(estimate->geodesic_deg);
    cell.false_removals += estimate->false_removals;
    cell.missed_outliers += estimate->missed_outliers;
    cell.exact += estimate->false_removals == 0 && estimate->missed_outliers == 0;
    if (!estimate->nees) return;
    cell.nees.add(*estimate->nees);
    cell.nees_covered += *estimate->nees <= kChiSquared6At95;
  }

  static void add_orientation(const TrialRecord& trial, CellAccumulator& cell) {
    const OrientationRecord* const record = find_orientation(trial, cell.cell.solver);
    if (record == nullptr) return;
    cell.cell.failures += record->failures > 0;
    cell.cell.failed_copies += record->failures;
    cell.angle_error_deg.add(record->angle_error_deg);
    cell.theta_error_deg.add(record->theta_error_deg);
    cell.geodesic_deg.add(record->geodesic_deg);
    cell.t_error_percent.add(record->t_error_percent);
    cell.time_ns.add(record->time_ns);
  }

  CellSummary finished_cell(const CellAccumulator& accumulator, int trials) const {
    CellSummary cell = accumulator.cell;
    cell.trials = trials;
    const auto statistics = [&](const ErrorStatistics& errors, std::string_view name) {
      return errors.summary(
          study_.seed, fmt::format("bootstrap/{}/{}/{}",
                                   study_.conditions[static_cast<size_t>(cell.condition)].label,
                                   cell.solver, name));
    };
    cell.theta_error_deg = statistics(accumulator.theta_error_deg, "theta_error_deg");
    cell.t_error_percent = statistics(accumulator.t_error_percent, "t_error_percent");
    cell.geodesic_deg = statistics(accumulator.geodesic_deg, "geodesic_deg");
    cell.failure_rate_ci95 = wilson_interval(cell.failures, trials);
    if (study_.kind == StudyKind::kOrientation) {
      cell.angle_error_deg = statistics(accumulator.angle_error_deg, "angle_error_deg");
      if (study_.takes_times()) cell.time_ns = statistics(accumulator.time_ns, "time_ns");
      return cell;
    }
    cell.ratio_to_oracle = accumulator.to_oracle.value();
    cell.ratio_to_oracle_ci95 = accumulator.to_oracle.ci95();
    cell.ratio_to_bound = accumulator.to_bound.value();
    cell.ratio_to_bound_ci95 = accumulator.to_bound.ci95();
    const ErrorSummary nees = statistics(accumulator.nees, "nees");
    cell.nees.trials = accumulator.nees.count();
    cell.nees.mean = nees.mean;
    cell.nees.mean_ci95 = nees.mean_ci95;
    if (cell.nees.trials > 0) {
      cell.nees.coverage95 =
          static_cast<double>(accumulator.nees_covered) / static_cast<double>(cell.nees.trials);
    }
    cell.nees.coverage95_ci95 = wilson_interval(accumulator.nees_covered, cell.nees.trials);
    if (trials == 0) return cell;
    cell.false_removals = static_cast<double>(accumulator.false_removals) / trials;
    cell.missed_outliers = static_cast<double>(accumulator.missed_outliers) / trials;
    cell.exact_set_rate = static_cast<double>(accumulator.exact) / trials;
    cell.exact_set_rate_ci95 = wilson_interval(accumulator.exact, trials);
    return cell;
  }

  CellObservations finished_observations(const ConditionAccumulator& condition, int index) const {
    CellObservations cell;
    cell.condition = index;
    cell.trials = condition.trials;
    cell.repeated = condition.repeats.count();
    if (study_.kind == StudyKind::kOrientation) return cell;
    cell.inlier_rms_px = condition.inlier_error_px.root();
    if (cell.trials > 0) {
      cell.found = static_cast<double>(condition.found) / cell.trials;
      cell.outliers = static_cast<double>(condition.outliers) / cell.trials;
    }
    const int bounds = condition.bound_geodesic_deg.count;
    cell.bound_theta_deg = bounds > 0 ? condition.bound_theta_deg / bounds : kNoNumber;
    cell.bound_t_percent = bounds > 0 ? condition.bound_t_percent / bounds : kNoNumber;
    cell.bound_geodesic_deg = condition.bound_geodesic_deg.root();
    return cell;
  }

  const Study& study_;
  Positions positions_;
  std::vector<ConditionAccumulator> conditions_;
};

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
  Summariser summariser(study);
  if (study.kind != StudyKind::kImages) {
    trials([&](const TrialRecord& trial) {
      summariser.observe(trial);
      summariser.judge(trial);
    });
    return summariser.finish();
  }
  ExtractionStatistics extraction(study);
  trials([&](const TrialRecord& trial) {
    summariser.observe(trial);
    extraction.add(trial);
  });
  trials([&](const TrialRecord& trial) { summariser.judge(trial); });
  Summary summary = summariser.finish();
  summary.extraction = std::move(extraction);
  return summary;
}

Summary summarise(const Study& study, std::span<const TrialRecord> trials) {
  return summarise(study, in_order(trials));
}

// Degrees and percent: exact data leave 1e-9 and less, the finest images 1e-3.
constexpr double kRoundingAlone = 1e-6;

std::optional<int64_t> trials_needed(const CellSummary& cell, double target) {
  std::optional<int64_t> most;
  for (const ErrorSummary* error : {&cell.theta_error_deg, &cell.t_error_percent}) {
    if (error->mean < kRoundingAlone) continue;
    const auto needed = trials_for(target, cell.trials, error->mean, error->mean_ci95);
    if (needed && (!most || *needed > *most)) most = needed;
  }
  return most;
}

}  // namespace sightline
