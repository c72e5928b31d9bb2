// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/doors/registration_solver.h"

#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "pose/pose.h"
#include "registration/registration.h"

namespace sightline {
namespace {

constexpr double kUnknownAlbedo = 0.8;  // that a part has where a file says nothing

// The pose of the features found, as good as they allow. None where it is not to be had, or so far
// from the prior that the features are more probably wrong than the prior.
std::optional<Pose> pose_of_features(const SolverQuestion& question, const PosePrior& prior) {
  constexpr double kFarthest = 30;  // squared sds: one in 20000 of six normal numbers
  const PoseEstimate estimate =
      find_pose_solver("orpe_weighed")->solve(question.problem, question.options);
  if (estimate.status != PoseStatus::kOk || !estimate.covariance) return std::nullopt;
  const Vector6d error = change_between(prior.cam_from_target, estimate.cam_from_target);
  const Matrix6d spread = prior.covariance + *estimate.covariance;
  const bool is_near = error.dot(spread.ldlt().solve(error)) < kFarthest;
  return is_near ? std::optional(estimate.cam_from_target) : std::nullopt;
}

EstimateOutcome outcome_of(RegistrationStatus status) {
  return from_string<EstimateOutcome>(to_string(status));
}

RegistrationOptions options_of(const QuestionImage& shown) {
  RegistrationOptions options;
  options.noise_sd_grey = shown.registration.noise_sd_grey;
  options.bits = shown.scene.sensor.bits;
  options.is_srgb = shown.scene.sensor.is_srgb;
  options.camera_errors = {shown.registration.focal_sd_fraction,
                           shown.registration.principal_point_sd_px,
                           shown.registration.distortion_sd};
  return options;
}

RegistrationTask task_of(const QuestionImage& shown, const Camera& camera) {
  return {*shown.registration.mesh,
          camera,
          shown.image,
          std::exp2(shown.scene.sensor.bits) - 1,
          shown.prior,
          std::nullopt};
}

SolverAnswer lay_on_image(const SolverQuestion& question, RegistrationRegion region) {
  if (question.image == nullptr) return {};
  const QuestionImage& shown = *question.image;
  RegistrationOptions options = options_of(shown);
  options.region = region;
  RegistrationTask task = task_of(shown, question.problem.camera);
  if (shown.registration.start == RegistrationStart::kAtFeatures) {
    task.start = pose_of_features(question, shown.prior);
  }
  const Registration registration = register_mesh(task, options);
  SolverAnswer answer;
  answer.outcome = outcome_of(registration.status);
  if (!registration.is_ok()) return answer;
  answer.estimate.status = PoseStatus::kOk;
  answer.estimate.cam_from_target = registration.cam_from_target;
  answer.estimate.covariance = registration.covariance;
  return answer;
}

TrialSolver registration_solver(const char* name, const char* summary, RegistrationRegion region) {
  return {
      .name = name,
      .summary = summary,
      .looks_at_image = true,
      .solve = [region](const SolverQuestion& question) { return lay_on_image(question, region); }};
}

}  // namespace

std::shared_ptr<const Mesh> registration_mesh(const std::shared_ptr<const Target>& target,
                                              const RegistrationSetup& setup) {
  auto mesh = std::make_shared<Mesh>(decimated(target, setup.mesh_fraction)->mesh);
  if (!setup.knows_albedos) {
    for (Part& part : mesh->parts) part.albedo = kUnknownAlbedo;
  }
  return mesh;
}

std::optional<ModelImage> model_beside(const QuestionImage& shown, const Camera& camera,
                                       const Pose& cam_from_target) {
  if (shown.registration.mesh == nullptr) return std::nullopt;
  return model_image(task_of(shown, camera), options_of(shown), cam_from_target);
}

std::vector<TrialSolver> registration_solvers(RegistrationUse use) {
  std::vector<TrialSolver> solvers;
  if (use == RegistrationUse::kImage || use == RegistrationUse::kBoth) {
    solvers.push_back(registration_solver("registration_image",
                                          "the mesh laid on the image, grey levels compared",
                                          RegistrationRegion::kImage));
  }
  if (use == RegistrationUse::kOutline || use == RegistrationUse::kBoth) {
    solvers.push_back(registration_solver("registration_outline",
                                          "the same in a band along the target's outline",
                                          RegistrationRegion::kOutline));
  }
  return solvers;
}

}  // namespace sightline
