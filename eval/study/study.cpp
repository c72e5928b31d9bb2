// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/study/study.h"

#include <algorithm>

#include <fmt/format.h>

namespace sightline {

std::string_view to_string(PoseInput input) {
  constexpr std::string_view kNames[] = {"exact", "noise", "inliers"};
  return kNames[static_cast<int>(input)];
}

std::string name_with(std::string_view solver, PoseInput input) {
  return fmt::format("{}/{}", solver, to_string(input));
}

bool can_be_given_inputs(const TrialSolver& solver) {
  return !solver.evaluation_only && !solver.is_recorded && !solver.looks_at_image;
}

std::vector<std::string> Solving::names() const {
  std::vector<std::string> names;
  for (const TrialSolver& solver : solvers) names.emplace_back(solver.name);
  for (const PoseInput input : inputs) {
    for (const TrialSolver& solver : solvers) {
      if (can_be_given_inputs(solver)) names.push_back(name_with(solver.name, input));
    }
  }
  return names;
}

int64_t ImageStudy::draw_of(int64_t trial) const {
  const auto conditions = static_cast<int64_t>(cells.size());
  const auto poses_each = conditions / static_cast<int64_t>(setups.size());
  return trial / conditions * poses_each + cells[trial % conditions].pose;
}

bool ImageStudy::asks_processes() const {
  const auto is_asked = [](const TrialSolver& solver) { return solver.process != nullptr; };
  const auto has_asked_guest = [](const ImageSetup& setup) {
    return setup.guest && setup.guest->process;
  };
  return std::any_of(solving.solvers.begin(), solving.solvers.end(), is_asked) ||
         std::any_of(setups.begin(), setups.end(), has_asked_guest);
}

const Sighting& ImageStudy::sighting_of(int64_t trial) const {
  return sighted->set->sightings[static_cast<size_t>(draw_of(trial))];
}

TrialName ImageStudy::name_of(int64_t trial) const {
  if (!sighted) return {.trial = trial, .im_id = draw_of(trial)};
  const Sighting& sighting = sighting_of(trial);
  return {trial, sighting.scene_id, sighting.im_id, sighting.gt_id};
}

const PoseStudy* Study::pose_study() const {
  if (const ImageStudy* const study = images()) return study;
  return numeric();
}

std::span<const TrialSolver> Study::solvers() const {
  const PoseStudy* const study = pose_study();
  if (study == nullptr) return {};
  return study->solving.solvers;
}

const TrialSolver* Study::find_solver(std::string_view solver_name) const {
  for (const TrialSolver& solver : solvers()) {
    if (solver.name == solver_name) return &solver;
  }
  return nullptr;
}

std::string_view name_of(const StudyMethod& method) {
  return std::visit([](const auto* one) { return one->name; }, method);
}

bool OrientationStudy::has_outliers() const {
  return std::any_of(cells.begin(), cells.end(),
                     [](const OrientationCell& cell) { return cell.outliers > 0; });
}

std::vector<std::string> Study::solver_names() const {
  if (const PoseStudy* const study = pose_study()) return study->solving.names();
  std::vector<std::string> names;
  for (const StudyMethod& method : orientation()->methods) names.emplace_back(name_of(method));
  return names;
}

const PoseLaw* Study::pose_law() const {
  if (const ImageStudy* const study = images()) return &study->pose_law();
  return numeric() != nullptr ? &numeric()->setups.front().poses : nullptr;
}

const Camera& Study::camera_of(int64_t trial) const {
  if (const NumericStudy* const study = numeric()) {
    return study->setup_of(condition_of(trial)).camera;
  }
  const ImageStudy& study = std::get<ImageStudy>(kind);
  return study.sighted ? study.sighting_of(trial).camera : study.camera_of(condition_of(trial));
}

}  // namespace sightline
