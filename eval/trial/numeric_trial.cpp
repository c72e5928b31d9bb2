// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/trial/numeric_trial.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "eval/trial/estimates.h"
#include "eval/trial/labels.h"

namespace sightline {
namespace {

// Brings `count` items, drawn without replacement, to the front.
template <typename Item>
void draw_to_front(std::vector<Item>& items, int count, RandomStream& stream) {
  for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
    const uint64_t left = items.size() - i;
    std::swap(items[i], items[i + ((uint64_t{stream.bits()} * left) >> 32)]);
  }
}

// The exact projections; none when a feature is behind the camera.
std::vector<ObservationRecord> project_features(const NumericStudy& study,
                                                const Pose& cam_from_target) {
  std::vector<ObservationRecord> records;
  for (const int feature : study.features) {
    const TargetFeature& of_target = study.target->features[feature];
    const auto pixel = project(study.camera, cam_from_target * of_target.position_m);
    if (!pixel) return {};
    ObservationRecord& record = records.emplace_back();
    record.feature = of_target.name;
    record.is_visible = true;
    record.true_pixel = *pixel;
    record.pixel = *pixel;
  }
  return records;
}

void add_noise(double sd_px, RandomStream& stream, std::vector<ObservationRecord>& records) {
  for (ObservationRecord& record : records) {
    const double du = sd_px * stream.normal();
    record.pixel += Eigen::Vector2d(du, sd_px * stream.normal());
  }
}

Eigen::Vector2d drawn_displacement(const PlantedOutliers& law, RandomStream& stream) {
  const double angle = 2 * std::numbers::pi * stream.uniform();
  const double size_px = stream.uniform(law.size_px.min, law.size_px.max);
  return (law.law == OutlierLaw::kFixed ? law.size_px.max : size_px) *
         Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

void swap_pairs(const NumericStudy& study, int count, RandomStream& stream,
                std::vector<ObservationRecord>& records) {
  std::vector<std::pair<int, int>> pairs = mirrored_pairs(*study.target, study.features);
  draw_to_front(pairs, count, stream);
  for (const auto& [a, b] : std::span(pairs).first(static_cast<size_t>(count))) {
    std::swap(records[a].pixel, records[b].pixel);
    records[a].is_outlier = true;
    records[b].is_outlier = true;
  }
}

// What failed together in one of the model's trials.
void replay_failures(const OutlierModel& model, RandomStream& stream,
                     std::vector<ObservationRecord>& records) {
  const auto& failures = model.trials[(uint64_t{stream.bits()} * model.trials.size()) >> 32];
  for (const OutlierModel::Failure& failure : failures) {
    const auto record = std::find_if(
        records.begin(), records.end(),
        [&](const ObservationRecord& candidate) { return candidate.feature == failure.feature; });
    if (record == records.end()) continue;
    if (failure.is_missing) {
      record->status = ObservationOutcome::kMissing;
    } else {
      record->pixel = record->true_pixel + failure.displacement_px;
      record->is_outlier = true;
    }
  }
}

void plant_outliers(const NumericStudy& study, int count, RandomStream& stream,
                    std::vector<ObservationRecord>& records) {
  const PlantedOutliers& law = study.planted;
  if (law.law == OutlierLaw::kModel) {
    replay_failures(*law.model, stream, records);
    return;
  }
  if (law.law == OutlierLaw::kSwapped) {
    swap_pairs(study, count / 2, stream, records);
    return;
  }
  std::vector<ObservationRecord*> chosen;
  for (ObservationRecord& record : records) chosen.push_back(&record);
  draw_to_front(chosen, count, stream);
  chosen.resize(static_cast<size_t>(count));
  Eigen::Vector2d shift = drawn_displacement(law, stream);
  for (ObservationRecord* record : chosen) {
    record->pixel += shift;
    record->is_outlier = true;
    if (law.law != OutlierLaw::kClustered) shift = drawn_displacement(law, stream);
  }
}

FoundPoints all_points(const NumericStudy& study, const TrialRecord& record) {
  const NumericCell& cell = study.cells[record.condition];
  const PoseTrial& trial = record.pose_trial();
  FoundPoints found;
  found.trial = study.name_of(record.trial);
  PoseProblem& problem = found.problem;
  problem.camera = study.camera;
  if (study.solving.start == Start::kPrior) {
    problem.initial_cam_from_target = trial.prior_cam_from_target;
  }
  if (study.is_sigma_known) problem.sigma_px = cell.noise_px;
  for (size_t i = 0; i < trial.observations.size(); ++i) {
    if (!trial.observations[i].is_found()) continue;
    problem.points_in_target.push_back(study.feature(static_cast<int>(i)).position_m);
    problem.pixels.push_back(trial.observations[i].pixel);
    found.slots.push_back(static_cast<int>(i));
  }
  return found;
}

}  // namespace

TrialRecord run_numeric_trial(const NumericStudy& study, uint64_t seed, int64_t index) {
  TrialRecord record;
  record.trial = index;
  record.condition = static_cast<int>(index % study.cells.size());
  const NumericCell& cell = study.cells[record.condition];

  RandomStream pose_stream(seed, "pose", index);
  record.true_cam_from_target = drawn_pose(study.poses, pose_stream);
  PoseTrial& trial = record.pose_trial();
  trial.observations = project_features(study, record.true_cam_from_target);
  if (trial.observations.empty()) {
    trial.estimates = failed_estimates(study.solving, EstimateOutcome::kNotImaged);
    return record;
  }
  if (study.solving.start == Start::kPrior) {
    RandomStream prior_stream(seed, "prior", index);
    trial.prior_cam_from_target =
        draw_prior(record.true_cam_from_target, study.camera, study.prior, prior_stream);
  }
  RandomStream noise_stream(seed, "pixel", index);
  add_noise(cell.noise_px, noise_stream, trial.observations);
  RandomStream outlier_stream(seed, "outliers", index);
  plant_outliers(study, cell.outliers, outlier_stream, trial.observations);
  for (ObservationRecord& observation : trial.observations) {
    if (observation.is_found()) {
      observation.error_px = (observation.pixel - observation.true_pixel).norm();
      observation.label =
          observation.is_outlier ? ObservationLabel::kPlanted : ObservationLabel::kInlier;
    } else {
      observation.label = ObservationLabel::kMissing;
    }
  }
  trial.estimates = estimates_of(study, seed, all_points(study, record), record);
  return record;
}
}  // namespace sightline
