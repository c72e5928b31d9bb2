// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/trial/image_trial.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "eval/doors/trial_extractor.h"
#include "eval/records/line_records.h"
#include "eval/trial/estimates.h"
#include "eval/trial/labels.h"
#include "eval/trial/line_labels.h"
#include "eval/trial/passes.h"
#include "features/prediction.h"

namespace sightline {
namespace {

FoundPoints found_points(const ImageStudy& study, const Trial& trial, const Pose& looked_around) {
  FoundPoints found;
  found.trial = study.name_of(trial.record.trial);
  if (study.sighted) found.symmetries = &study.sighted->set->symmetries;
  PoseProblem& problem = found.problem;
  problem.camera = trial.scene.camera;
  if (study.solving.start == Start::kPrior) {
    problem.initial_cam_from_target = looked_around;
  }
  for (size_t i = 0; i < trial.observations.size(); ++i) {
    const Observation& observation = trial.observations[i];
    if (observation.status != ObservationStatus::kFound) continue;
    problem.points_in_target.push_back(study.target->features[observation.feature].position_m);
    problem.pixels.push_back(observation.pixel);
    problem.covariances_px2.push_back(observation.covariance_px2);
    found.slots.push_back(static_cast<int>(i));
  }
  for (const LineRecord& line : trial.record.lines()) {
    problem.lines.push_back(line_of(line, *study.target).value());
  }
  return found;
}

std::vector<ObservationRecord> compare_with_truth(const ImageStudy& study, const Trial& trial) {
  std::vector<ObservationRecord> records;
  for (const Observation& observation : trial.observations) {
    const FeatureTruth& truth = trial.frame.truth.target().features[observation.feature];
    ObservationRecord record;
    record.feature = study.target->features[observation.feature].name;
    record.status = from_string<ObservationOutcome>(to_string(observation.status));
    record.true_pixel = truth.pixel;
    const LabelledObservation labelled =
        label(observation, trial.scene, trial.frame, study.setup_of(trial.record.condition).limits);
    record.is_visible = labelled.is_visible;
    record.label = labelled.label;
    if (record.is_found()) {
      record.pixel = observation.pixel;
      record.error_px = labelled.error_px;
      record.error_sigmas = labelled.error_sigmas;
      record.is_outlier = labelled.is_outlier;
    }
    records.push_back(std::move(record));
  }
  return records;
}

std::vector<LineRecord> lines_against_truth(const ImageStudy& study, const Trial& trial) {
  const ImageSetup& setup = study.setup_of(trial.record.condition);
  if (!setup.uses_lines) return {};
  return compare_lines(trial.observations, *study.target, trial.scene.camera,
                       trial.record.true_cam_from_target, setup.limits);
}

// Scene and frame of a trial, drawn and rendered. Returns why there is none.
std::optional<EstimateOutcome> render_frame(const ImageStudy& study, uint64_t seed,
                                            Renderer& renderer, Trial& trial) {
  const ImageCell& cell = study.cells[trial.record.condition];
  const int64_t draw = study.draw_of(trial.record.trial);
  const DrawnScene drawn = draw_scene(study.setups[cell.setup].scene, cell.pose, seed, draw);
  trial.scene = drawn.scene;
  trial.record.redraws = drawn.redraws;
  if (!drawn.is_imageable) return EstimateOutcome::kNotImaged;
  trial.frame = renderer.render(trial.scene, RandomStream(seed, "sensor", draw));
  return std::nullopt;
}

// The same from a data set.
std::optional<EstimateOutcome> read_frame(const ImageStudy& study, SetFiles& files, Trial& trial) {
  SetFrame shown =
      read_set_frame(study.target, study.setup_of(trial.record.condition).scene.sensor.bits,
                     study.sighting_of(trial.record.trial), files);
  trial.scene = std::move(shown.scene);
  if (!shown.problem) trial.frame = std::move(shown.frame);
  return shown.problem;
}

// The prior of a trial with a scene: drawn about the truth, or given; none where there is none.
std::optional<Pose> prior_for(const ImageStudy& study, uint64_t seed, const Trial& trial) {
  if (study.sighted && study.sighted->has_given_priors) {
    return study.sighting_of(trial.record.trial).prior_cam_from_target;
  }
  RandomStream stream(seed, "prior", study.draw_of(trial.record.trial));
  return draw_prior(trial.scene.cam_from_target, trial.scene.camera,
                    study.setup_of(trial.record.condition).prior, stream);
}

// The first half of a trial: its scene, frame and prior. Returns why there is none of them.
std::optional<EstimateOutcome> begin_trial(const ImageStudy& study, uint64_t seed, int64_t index,
                                           Renderer& renderer, SetFiles& files, Trial& trial) {
  TrialRecord& record = trial.record;
  record.trial = index;
  record.condition = static_cast<int>(index % study.cells.size());
  const std::optional<EstimateOutcome> problem =
      study.sighted ? read_frame(study, files, trial) : render_frame(study, seed, renderer, trial);
  record.true_cam_from_target = trial.scene.cam_from_target;
  if (problem) return problem;
  const std::optional<Pose> prior = prior_for(study, seed, trial);
  if (!prior) return EstimateOutcome::kNoPrior;
  record.pose_trial().prior_cam_from_target = *prior;
  return std::nullopt;
}

QuestionImage question_image(const ImageStudy& study, const Trial& trial) {
  const ImageSetup& setup = study.setup_of(trial.record.condition);
  return {
      trial.frame.image, trial.scene,
      prior_of(trial.record.pose_trial().prior_cam_from_target, trial.scene.camera, setup.prior),
      setup.registration};
}

// What a process found in a trial's frame, as far as it is recorded.
std::vector<Observation> recorded_observations(const ImageStudy& study, const Trial& trial,
                                               std::span<const ObservationRecord> recorded) {
  const PosePrior prior =
      prior_of(trial.record.pose_trial().prior_cam_from_target, trial.scene.camera,
               study.setup_of(trial.record.condition).prior);
  std::vector<Observation> observations = missing_observations(
      predict_features(*study.target, study.features, trial.scene.camera, prior));
  for (size_t i = 0; i < std::min(observations.size(), recorded.size()); ++i) {
    if (!recorded[i].is_found()) continue;
    observations[i].status = ObservationStatus::kFound;
    observations[i].pixel = recorded[i].pixel;
  }
  return observations;
}

}  // namespace

Trial run_image_trial(const ImageStudy& study, uint64_t seed, int64_t index, Renderer& renderer) {
  SetFiles files;
  return run_image_trial(study, seed, index, renderer, files);
}

Trial run_image_trial(const ImageStudy& study, uint64_t seed, int64_t index, Renderer& renderer,
                      SetFiles& files) {
  Trial trial;
  if (const auto problem = begin_trial(study, seed, index, renderer, files, trial)) {
    trial.record.pose_trial().estimates = failed_estimates(study.solving, *problem);
    return trial;
  }
  extract_and_solve(study, seed, trial, renderer);
  return trial;
}

Trial recall_image_trial(const ImageStudy& study, uint64_t seed, const TrialRecord& recorded,
                         Renderer& renderer) {
  Trial trial;
  PoseTrial& pose_trial = trial.record.pose_trial();
  SetFiles files;
  if (!begin_trial(study, seed, recorded.trial, renderer, files, trial)) {
    const auto& guest = study.setup_of(trial.record.condition).guest;
    if (guest && guest->process) {
      trial.observations = recorded_observations(study, trial, recorded.observations());
      pose_trial.observations = recorded.pose_trial().observations;
    } else {
      trial.observations =
          extract(study, trial.record, trial.scene, trial.frame, renderer).observations;
      pose_trial.observations = compare_with_truth(study, trial);
      pose_trial.lines = lines_against_truth(study, trial);
    }
  }
  pose_trial.estimates = recorded.pose_trial().estimates;
  return trial;
}

std::optional<ModelImage> model_beside(const ImageStudy& study, const Trial& trial,
                                       const Pose& cam_from_target) {
  if (trial.frame.image.empty()) return std::nullopt;
  return model_beside(question_image(study, trial), trial.scene.camera, cam_from_target);
}

void extract_and_solve(const ImageStudy& study, uint64_t seed, Trial& trial, Renderer& renderer) {
  TrialRecord& record = trial.record;
  PoseTrial& pose_trial = record.pose_trial();
  Extraction extraction = extract(study, record, trial.scene, trial.frame, renderer);
  trial.observations = std::move(extraction.observations);
  pose_trial.observations = compare_with_truth(study, trial);
  pose_trial.lines = lines_against_truth(study, trial);
  if (extraction.problem) {
    pose_trial.estimates = failed_estimates(study.solving, *extraction.problem);
    return;
  }
  FoundPoints found = found_points(study, trial, extraction.cam_from_target);
  found.image.emplace(question_image(study, trial));
  pose_trial.estimates = estimates_of(study, seed, found, record);
}

}  // namespace sightline
