// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/doors/image_bound_solver.h"

#include <memory>
#include <optional>

#include "eval/doors/registration_solver.h"
#include "pose/bounds.h"
#include "registration/image_bound.h"
#include "scenes/random/random.h"

namespace sightline {
namespace {

// A draw of normal numbers whose covariance has that root.
Vector6d drawn(const Matrix6d& root, RandomStream stream) {
  Vector6d unit;
  for (int i = 0; i < 6; ++i) unit[i] = stream.normal();
  return root * unit;
}

// The bounds of the trial that was asked for last, which one solver after the other asks for. A
// study's trials are run one by one.
struct LastBounds {
  int64_t trial = -1;
  ImageBounds bounds;
};

SolverAnswer bound_as_answer(const SolverQuestion& question, uint64_t seed, const char* name,
                             std::optional<Matrix6d> ImageBounds::*which, LastBounds& last) {
  if (question.image == nullptr) return {};
  const Scene& scene = question.image->scene;
  if (last.trial != question.trial.trial) {
    Renderer renderer;
    last = {question.trial.trial, image_bounds(scene, renderer)};
  }
  const std::optional<Matrix6d> covariance = last.bounds.*which;
  const std::optional<Matrix6d> root = covariance ? root_of(*covariance) : std::nullopt;
  SolverAnswer answer;
  if (!root) {
    answer.outcome = EstimateOutcome::kDegenerate;
    return answer;
  }
  answer.outcome = EstimateOutcome::kOk;
  answer.estimate.status = PoseStatus::kOk;
  const RandomStream stream(seed, name, static_cast<uint64_t>(question.trial.trial));
  answer.estimate.cam_from_target = retract(scene.cam_from_target, drawn(*root, stream));
  answer.estimate.covariance = covariance;
  return answer;
}

TrialSolver bound_solver(const char* name, const char* summary, uint64_t seed,
                         std::optional<Matrix6d> ImageBounds::*which,
                         const std::shared_ptr<LastBounds>& last) {
  return {.name = name,
          .summary = summary,
          .evaluation_only = true,
          .looks_at_image = true,
          .solve = [=](const SolverQuestion& question) {
            return bound_as_answer(question, seed, name, which, *last);
          }};
}

}  // namespace

std::vector<TrialSolver> image_bound_solvers(uint64_t seed) {
  const auto last = std::make_shared<LastBounds>();
  return {bound_solver("image_bound", "what the image's Cramér-Rao bound leaves, light unknown",
                       seed, &ImageBounds::unknown_light, last),
          bound_solver("outline_bound", "the same of the outline alone, contrast unknown", seed,
                       &ImageBounds::outline, last)};
}

}  // namespace sightline
