// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/trial/passes.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "features/extractor.h"
#include "features/image_line.h"
#include "features/prediction.h"
#include "pose/solver.h"

namespace sightline {
namespace {

constexpr double kGatePx = 35;  // farther than this no predicted feature moves from one prior
constexpr double kWrongLightRad = 18 * std::numbers::pi / 180;
// Of the floors of sigma, what is left once the bias is removed.
constexpr double kFloorAfterKnownLight = 0.25;
constexpr double kFloorAfterWrongLight = 0.5;

// Where a study looks: its frame, features and options.
struct Task {
  const ImageStudy& study;
  const ImageSetup& setup;
  const Camera& camera;
  double white;
};

std::vector<Observation> look(const Task& task, const cv::Mat& image, const PosePrior& prior,
                              const ExtractorOptions& options) {
  const PredictedView view =
      predict_features(*task.study.target, task.study.features, task.camera, prior);
  return extract_features(image, task.white, view, task.setup.extractors, options);
}

int found_count(const std::vector<Observation>& observations) {
  return static_cast<int>(
      std::count_if(observations.begin(), observations.end(), [](const Observation& observation) {
        return observation.status == ObservationStatus::kFound;
      }));
}

// The prior as six points about the target's middle, seen where it expects them: twelve coordinates
// for six numbers, so each with twice its variance.
void add_prior(const Task& task, const PosePrior& prior, PoseProblem& problem) {
  double squares_m2 = 0;
  for (const int feature : task.study.features) {
    squares_m2 += task.study.target->features[feature].position_m.squaredNorm();
  }
  const double radius_m = std::sqrt(squares_m2 / static_cast<double>(task.study.features.size()));
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector3d point = side * radius_m * Eigen::Vector3d::Unit(axis);
      const auto pixel = project(task.camera, prior.cam_from_target * point);
      if (!pixel) continue;
      problem.points_in_target.push_back(point);
      problem.pixels.push_back(*pixel);
      // A known prior is no point: it needs some width to be weighed at all.
      constexpr double kLeastVariancePx2 = 1e-4;
      problem.covariances_px2.push_back(2 * predicted_covariance_px2(task.camera, prior, point) +
                                        kLeastVariancePx2 * Eigen::Matrix2d::Identity());
    }
  }
}

bool passes_gate(const Task& task, const Pose& prior, const Pose& pose) {
  return std::all_of(task.study.features.begin(), task.study.features.end(), [&](int feature) {
    const Eigen::Vector3d& position = task.study.target->features[feature].position_m;
    const auto before = project(task.camera, prior * position);
    const auto after = project(task.camera, pose * position);
    return before && after && (*after - *before).norm() <= kGatePx;
  });
}

// The lines along edges that were found, as a problem has them.
void add_lines(const Task& task, const std::vector<Observation>& observations,
               PoseProblem& problem) {
  for (const Observation& observation : observations) {
    const TargetFeature& feature = task.study.target->features[observation.feature];
    for (const EdgeLine& found : observation.edge_lines) {
      problem.lines.push_back(line_observation(found, feature));
    }
  }
}

// Who makes the pose between two passes: where few features are found and lines may be used,
// consensus with lines.
const PoseSolver& solver_between(const Task& task, const std::vector<Observation>& observations,
                                 PoseProblem& problem) {
  constexpr int kEnoughFeatures = 5;
  if (!task.setup.uses_lines || found_count(observations) >= kEnoughFeatures) {
    return *find_pose_solver("orpe_weighed");
  }
  add_lines(task, observations, problem);
  return *find_pose_solver("consensus");
}

// The pose of these observations and the prior. None where it cannot be had or the gate is shut.
std::optional<PosePrior> improved(const Task& task, const std::vector<Observation>& observations,
                                  const PosePrior& prior, const Pose& start) {
  PoseProblem problem;
  problem.camera = task.camera;
  problem.initial_cam_from_target = start;
  for (const Observation& observation : observations) {
    if (observation.status != ObservationStatus::kFound) continue;
    problem.points_in_target.push_back(task.study.target->features[observation.feature].position_m);
    problem.pixels.push_back(observation.pixel);
    problem.covariances_px2.push_back(observation.covariance_px2);
  }
  add_prior(task, prior, problem);
  const PoseSolver& solver = solver_between(task, observations, problem);
  const PoseEstimate estimate = solver.solve(problem, task.study.solving.options);
  if (estimate.status != PoseStatus::kOk) return std::nullopt;
  if (!passes_gate(task, prior.cam_from_target, estimate.cam_from_target)) return std::nullopt;
  return PosePrior{estimate.cam_from_target, estimate.covariance.value()};
}

// What of a frame extractors see.
cv::Mat looked_at(const Frame& frame, const ImageSetup& setup) {
  const bool is_by_contrast = setup.channel == ExtractedChannel::kContrast;
  return is_by_contrast && !frame.colour.empty() ? frame.colour : frame.image;
}

// What is known of the target alone at that pose, free of noise.
cv::Mat rendering_at(const Pose& cam_from_target, const Scene& scene, const ImageSetup& setup,
                     Renderer& renderer) {
  Scene model;
  model.target = setup.bias_target;
  model.camera = scene.camera;
  model.cam_from_target = cam_from_target;
  model.light = scene.light;
  model.lamps = scene.lamps;
  model.environment = scene.environment;
  if (setup.channel == ExtractedChannel::kContrast) model.colouring = scene.colouring;
  model.background.level = scene.background.level;
  model.samples_per_pixel = scene.samples_per_pixel;
  model.sensor.psf_sigma_px = scene.sensor.psf_sigma_px;
  model.sensor.gain = scene.sensor.gain;
  model.sensor.read_noise_grey = 0;
  model.sensor.bits = scene.sensor.bits;
  model.sensor.is_srgb = scene.sensor.is_srgb;
  if (setup.bias_removal == BiasRemoval::kWrongLight) {
    const Eigen::Vector3d axis =
        model.light.to_light_in_cam.cross(Eigen::Vector3d(0.6, 0.8, 0)).normalized();
    model.light.to_light_in_cam =
        rotation_from_vector(kWrongLightRad * axis) * model.light.to_light_in_cam;
  }
  return looked_at(renderer.render(model, RandomStream(0, "no noise", 0)), setup);
}

// Takes from every observation what its extractor errs on a rendering whose truth is known. What is
// not found there is no longer trusted.
void remove_bias(const Task& task, const cv::Mat& rendering, const PosePrior& pose,
                 const ExtractorOptions& options, std::vector<Observation>& observations) {
  const std::vector<Observation> rendered = look(task, rendering, pose, options);
  for (size_t i = 0; i < observations.size(); ++i) {
    Observation& observation = observations[i];
    observation.edge_lines.clear();  // whose bias is not known
    if (observation.status != ObservationStatus::kFound) continue;
    if (rendered[i].status != ObservationStatus::kFound) {
      observation.status = rendered[i].status;
      continue;
    }
    observation.pixel -= rendered[i].pixel - rendered[i].predicted_px;
  }
}

Extraction ask_guest(const Task& task, int64_t trial, const cv::Mat& image,
                     const PosePrior& prior) {
  const ImageStudy& study = task.study;
  const PredictedView view = predict_features(*study.target, study.features, task.camera, prior);
  const auto picture = study.sighted ? study.sighting_of(trial).picture : std::filesystem::path();
  ExtractorAnswer answer =
      task.setup.guest->extract({image, task.white, view, study.name_of(trial), picture});
  if (answer.problem) answer.observations = missing_observations(view);
  return {std::move(answer.observations), prior.cam_from_target, answer.problem};
}

Extraction extract_in_passes(const Task& task, const Scene& scene, const cv::Mat& image,
                             const PosePrior& prior, Renderer& renderer) {
  const ImageSetup& setup = task.setup;
  ExtractorOptions options = setup.extractor_options;
  PosePrior pose = prior;
  Extraction extraction{look(task, image, prior, options), prior.cam_from_target};
  options.is_gated = true;
  for (int pass = 1; pass < setup.passes; ++pass) {
    const auto better = improved(task, extraction.observations, prior, extraction.cam_from_target);
    if (!better) break;
    auto observations = look(task, image, *better, options);
    if (2 * found_count(observations) < found_count(extraction.observations)) break;
    pose = *better;
    extraction = {std::move(observations), better->cam_from_target};
  }
  if (setup.bias_removal == BiasRemoval::kOff) return extraction;

  const auto last = improved(task, extraction.observations, prior, extraction.cam_from_target);
  if (!last) return extraction;
  options.search.floor_scale = setup.bias_removal == BiasRemoval::kKnownLight
                                   ? kFloorAfterKnownLight
                                   : kFloorAfterWrongLight;
  const cv::Mat rendering = rendering_at(last->cam_from_target, scene, setup, renderer);
  extraction = {look(task, image, *last, options), last->cam_from_target};
  remove_bias(task, rendering, *last, options, extraction.observations);
  return extraction;
}

}  // namespace

Extraction extract(const ImageStudy& study, const TrialRecord& record, const Scene& scene,
                   const Frame& frame, Renderer& renderer) {
  const ImageSetup& setup = study.setup_of(record.condition);
  const Task task{study, setup, scene.camera, std::exp2(scene.sensor.bits) - 1};
  const PosePrior prior =
      prior_of(record.pose_trial().prior_cam_from_target, scene.camera, setup.prior);
  if (setup.guest) return ask_guest(task, record.trial, frame.image, prior);
  return extract_in_passes(task, scene, looked_at(frame, setup), prior, renderer);
}

}  // namespace sightline
