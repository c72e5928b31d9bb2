// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/trial.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "eval/estimates.h"
#include "eval/pose_law.h"
#include "features/extractor.h"
#include "features/prediction.h"

namespace sightline {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Pose jittered_pose(const PoseLaw& law, int condition, RandomStream& stream) {
  const double dx = law.lateral_jitter_m * stream.uniform(-1, 1);
  const double dy = law.lateral_jitter_m * stream.uniform(-1, 1);
  return pose_from(law.theta_deg[condition], law.t_m[condition] + Eigen::Vector3d(dx, dy, 0));
}

bool has_all_features_inside(const Study& study, const Scene& scene) {
  return std::all_of(study.features.begin(), study.features.end(), [&](int feature) {
    const Eigen::Vector3d& position = study.target->features[feature].position_m;
    const auto pixel = project(scene.camera, scene.cam_from_target * position);
    return pixel && is_inside(scene.camera, *pixel);
  });
}

struct DrawnScene {
  Scene scene;
  int redraws = 0;
  bool is_imageable = true;
};

// The last draw stands when none has all features inside; it is a failed trial if it cannot be
// imaged at all.
DrawnScene draw_scene(const Study& study, int64_t index) {
  DrawnScene drawn;
  Scene& scene = drawn.scene;
  scene.target = study.target;
  scene.camera = study.camera;
  scene.background = study.background;
  scene.sensor = study.sensor;
  scene.samples_per_pixel = study.samples_per_pixel;
  scene.light = study.light;
  RandomStream light_stream(study.seed, "light", index);
  RandomStream pose_stream(study.seed, "pose", index);
  if (!study.poses.t_m.empty()) {
    scene.cam_from_target = jittered_pose(study.poses, study.condition_of(index), pose_stream);
  } else {
    scene.cam_from_target = drawn_pose(study.poses, pose_stream);
    while (drawn.redraws < study.poses.max_redraws && !has_all_features_inside(study, scene)) {
      scene.cam_from_target = drawn_pose(study.poses, pose_stream);
      ++drawn.redraws;
    }
  }
  const Eigen::Vector3d to_camera = -scene.cam_from_target.translation.normalized();
  scene.light.to_light_in_cam =
      light_stream.direction_near(to_camera, study.light_cone_deg * kDegree);
  drawn.is_imageable = why_not_imageable(scene).empty();
  return drawn;
}

FoundPoints found_points(const Study& study, const Trial& trial) {
  FoundPoints found;
  PoseProblem& problem = found.problem;
  problem.camera = study.camera;
  if (study.start == Start::kPrior) {
    problem.initial_cam_from_target = trial.record.prior_cam_from_target;
  }
  for (size_t i = 0; i < trial.observations.size(); ++i) {
    const Observation& observation = trial.observations[i];
    if (observation.status != ObservationStatus::kFound) continue;
    problem.points_in_target.push_back(study.target->features[observation.feature].position_m);
    problem.pixels.push_back(observation.pixel);
    problem.covariances_px2.push_back(observation.covariance_px2);
    found.slots.push_back(static_cast<int>(i));
  }
  return found;
}

std::vector<ObservationRecord> compare_with_truth(const Study& study, const Trial& trial) {
  std::vector<ObservationRecord> records;
  for (const Observation& observation : trial.observations) {
    const FeatureTruth& truth = trial.frame.truth.features[observation.feature];
    ObservationRecord record;
    record.feature = study.target->features[observation.feature].name;
    record.status = to_string(observation.status);
    record.is_visible = truth.is_visible;
    record.true_pixel = truth.pixel;
    if (record.is_found()) {
      record.pixel = observation.pixel;
      record.error_px = (observation.pixel - truth.pixel).norm();
      record.is_outlier = record.error_px > study.outlier_px;
    }
    records.push_back(std::move(record));
  }
  return records;
}

}  // namespace

Trial run_trial(const Study& study, int64_t index, Renderer& renderer) {
  Trial trial;
  TrialRecord& record = trial.record;
  record.trial = index;
  record.condition = study.condition_of(index);

  const DrawnScene drawn = draw_scene(study, index);
  trial.scene = drawn.scene;
  record.redraws = drawn.redraws;
  record.true_cam_from_target = drawn.scene.cam_from_target;
  if (!drawn.is_imageable) {
    record.estimates = failed_estimates(study);
    return trial;
  }
  trial.frame = renderer.render(trial.scene, RandomStream(study.seed, "sensor", index));

  RandomStream prior_stream(study.seed, "prior", index);
  record.prior_cam_from_target =
      draw_prior(record.true_cam_from_target, study.camera, study.prior, prior_stream);
  const auto predictions =
      predict_features(*study.target, study.features, study.camera, record.prior_cam_from_target);
  const double white = std::exp2(study.sensor.bits) - 1;
  trial.observations = extract_features(trial.frame.image, white, predictions, study.extractors,
                                        study.extractor_options);
  record.observations = compare_with_truth(study, trial);
  record.estimates = estimates_of(study, found_points(study, trial), record);
  return trial;
}

}  // namespace sightline
