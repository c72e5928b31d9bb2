// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "python/module/guests.h"

#include <memory>
#include <optional>

#include <pybind11/stl.h>

#include "python/module/arrays.h"
#include "python/module/long_call.h"

namespace sightline {
namespace {

namespace py = pybind11;

// What a study holds of a callable: it copies that as it likes, with Python's lock or without.
using SharedCallable = std::shared_ptr<const py::function>;

SharedCallable share(const py::function& callable) {
  return {new py::function(callable), [](const py::function* last) {
            const py::gil_scoped_acquire lock;
            delete last;
          }};
}

// Calls an adapter, which catches what the user's callable raises, but not what ends a program.
template <typename... Arguments>
py::object call(const SharedCallable& callable, Arguments&&... arguments) {
  try {
    return (*callable)(std::forward<Arguments>(arguments)...);
  } catch (py::error_already_set& error) {
    if (error.matches(PyExc_KeyboardInterrupt)) throw Interrupted();
    throw;
  }
}

py::tuple trial_tuple(const TrialName& trial) {
  return py::make_tuple(trial.trial, trial.scene_id, trial.im_id, trial.gt_id);
}

template <typename Value>
std::optional<Value> optional_from(const py::handle& object) {
  return object.is_none() ? std::nullopt : std::optional(object.cast<Value>());
}

Diagnosis diagnosis_from(const py::tuple& answers) {
  Diagnosis diagnosis;
  diagnosis.is_ambiguous = optional_from<bool>(answers[0]);
  diagnosis.removed_probability = optional_from<double>(answers[1]);
  diagnosis.is_removal_limit_reached = optional_from<bool>(answers[2]);
  diagnosis.is_test_failed = optional_from<bool>(answers[3]);
  return diagnosis;
}

// An outcome, a pose, the places removed, covariances (own and for unit noise), a diagnosis.
SolverAnswer solver_answer_from(const py::tuple& answer) {
  SolverAnswer out;
  out.outcome = from_string<EstimateOutcome>(answer[0].cast<std::string>());
  if (out.outcome != EstimateOutcome::kOk) return out;
  PoseEstimate& estimate = out.estimate;
  estimate.status = PoseStatus::kOk;
  estimate.cam_from_target = pose_from(answer[1].cast<Doubles>());
  estimate.removed = answer[2].cast<std::vector<int>>();
  if (!answer[3].is_none()) estimate.covariance = matrix6_from(answer[3].cast<Doubles>());
  if (!answer[4].is_none()) estimate.unit_covariance = matrix6_from(answer[4].cast<Doubles>());
  if (!answer[5].is_none()) estimate.diagnosis = diagnosis_from(answer[5].cast<py::tuple>());
  return out;
}

SolverAnswer ask_solver(const SharedCallable& adapter, const SolverQuestion& question) {
  const CallToPython lock;
  const PoseProblem& problem = question.problem;
  py::object covariances = py::none();
  py::object initial = py::none();
  if (!problem.covariances_px2.empty()) covariances = array_of(problem.covariances_px2);
  if (problem.initial_cam_from_target) initial = matrix_of(*problem.initial_cam_from_target);
  return solver_answer_from(call(adapter, rows_of(problem.points_in_target),
                                 rows_of(problem.pixels), numbers_of(problem.camera),
                                 problem.sigma_px, covariances, initial, question.features,
                                 trial_tuple(question.trial)));
}

// What an extractor is told of the features, an array or list each.
struct Expected {
  std::vector<std::string> names;
  std::vector<std::string> kinds;
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Matrix2d> covariances;
  std::vector<bool> is_hidden;
};

Expected expected_of(const PredictedView& view) {
  Expected out;
  for (const FeaturePrediction& prediction : view.features) {
    const TargetFeature& feature = view.target->features[prediction.feature];
    out.names.push_back(feature.name);
    out.kinds.emplace_back(to_string(feature.kind));
    out.positions.push_back(feature.position_m);
    out.pixels.push_back(prediction.pixel);
    out.covariances.push_back(prediction.covariance_px2);
    out.is_hidden.push_back(prediction.is_hidden);
  }
  return out;
}

// A problem, or pixels (NaN of what was not found) and their covariances.
ExtractorAnswer extractor_answer_from(const py::tuple& answer, const PredictedView& view) {
  ExtractorAnswer out;
  if (!answer[0].is_none()) {
    out.problem = from_string<EstimateOutcome>(answer[0].cast<std::string>());
    return out;
  }
  const std::vector<Eigen::Vector2d> pixels = pixels_from(answer[1].cast<Doubles>());
  const std::vector<Eigen::Matrix2d> covariances = covariances_from(answer[2].cast<Doubles>());
  out.observations = missing_observations(view);
  for (size_t i = 0; i < out.observations.size(); ++i) {
    if (!pixels[i].allFinite()) continue;
    out.observations[i].status = ObservationStatus::kFound;
    out.observations[i].pixel = pixels[i];
    out.observations[i].covariance_px2 = covariances[i];
  }
  return out;
}

ExtractorAnswer ask_extractor(const SharedCallable& adapter, const ExtractorQuestion& question) {
  const CallToPython lock;
  const PredictedView& view = question.view;
  const Expected expected = expected_of(view);
  const py::object answer =
      call(adapter, view_of(question.image), question.white, numbers_of(view.camera),
           matrix_of(view.cam_from_target), expected.names, expected.kinds,
           rows_of(expected.positions), rows_of(expected.pixels), array_of(expected.covariances),
           expected.is_hidden, trial_tuple(question.trial));
  return extractor_answer_from(answer, view);
}

constexpr const char* kFunctionSummary = "a function of Python";

}  // namespace

Guests guests_from(const NamedCallables& solvers, const NamedCallables& extractors) {
  Guests guests;
  for (const auto& [name, adapter] : solvers) {
    TrialSolver& solver = guests.solvers.emplace_back();
    solver.name = name;
    solver.summary = kFunctionSummary;
    solver.solve = [shared = share(adapter)](const SolverQuestion& question) {
      return ask_solver(shared, question);
    };
  }
  for (const auto& [name, adapter] : extractors) {
    TrialExtractor& extractor = guests.extractors.emplace_back();
    extractor.name = name;
    extractor.summary = kFunctionSummary;
    extractor.extract = [shared = share(adapter)](const ExtractorQuestion& question) {
      return ask_extractor(shared, question);
    };
  }
  return guests;
}

}  // namespace sightline
