// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/export.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "eval/datasets/conventions.h"
#include "eval/results/expected_trials.h"
#include "eval/results/store.h"
#include "eval/run/run_folder.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

// A run whose trials are read one by one.
struct ExportedRun {
  Study study;
  Store store;
  const ImageStudy* images;
  int condition;
  std::string solver;        // may be empty
  std::optional<int> scene;  // none: all

  TrialName name_of(int64_t trial) const {
    return images != nullptr ? images->name_of(trial) : NumericStudy::name_of(trial);
  }
  const SightedSet* set() const {
    return images != nullptr && images->sighted ? images->sighted->set.get() : nullptr;
  }
};

int condition_of(const ExportRequest& request, const Study& study) {
  std::vector<std::string> labels;
  for (const Condition& condition : study.conditions) labels.push_back(condition.label);
  if (request.condition.empty() && labels.size() == 1) return 0;
  const auto found = std::find(labels.begin(), labels.end(), request.condition);
  if (found != labels.end()) return static_cast<int>(found - labels.begin());
  throw InputError(fmt::format("{}: has several conditions; --condition must be one of {}",
                               request.run.string(), fmt::join(labels, " | ")));
}

std::string solver_of(const ExportRequest& request, const Study& study) {
  const std::vector<std::string> names = study.solver_names();
  if (request.solver.empty() && request.format == ExportFormat::kCoco) return "";
  if (request.solver.empty() && names.size() == 1) return names.front();
  if (std::find(names.begin(), names.end(), request.solver) != names.end()) return request.solver;
  if (request.solver.empty()) {
    throw InputError(fmt::format("{}: has several solvers; --solver must be one of {}",
                                 request.run.string(), fmt::join(names, ", ")));
  }
  throw InputError(fmt::format("--solver {}: is not in the run{}", request.solver,
                               suggestion(request.solver, names)));
}

ExportedRun open_run(const ExportRequest& request) {
  const std::filesystem::path file = request.run / kStoreFile;
  Store store = Store::open(file);
  Study study = study_from_meta(store.meta(), file);
  if (study.orientation() != nullptr) {
    throw InputError(
        fmt::format("{}: is of an orientation study, which has no images", request.run.string()));
  }
  const int condition = condition_of(request, study);
  std::string solver = solver_of(request, study);
  ExportedRun run{std::move(study), std::move(store),  nullptr,
                  condition,        std::move(solver), request.scene};
  run.images = run.study.images();
  return run;
}

// Calls `use` with every trial of the condition and, where one is chosen, of the scene.
template <typename Use>
void for_each_trial(const ExportedRun& run, const Use& use) {
  const ExpectedTrials expected = expected_trials(run.study, run.store);
  const NextTrial next = checked_reader(run.store, expected);
  bool is_any = false;
  for (auto trial = next(); trial; trial = next()) {
    const bool is_of_scene = !run.scene || run.name_of(trial->trial).scene_id == *run.scene;
    if (trial->condition != run.condition || !is_of_scene) continue;
    use(*trial);
    is_any = true;
  }
  if (is_any || !run.scene) return;
  throw InputError(fmt::format("--scene {}: is of no trial of the run", *run.scene));
}

// The same with what the solver found, where it has a pose.
template <typename Use>
void for_each_pose(const ExportedRun& run, const Use& use) {
  for_each_trial(run, [&](const TrialRecord& trial) {
    const EstimateRecord* const estimate = find_estimate(trial, run.solver);
    if (estimate != nullptr && estimate->is_ok()) use(trial, estimate->cam_from_target);
  });
}

std::string bop_lines(const ExportedRun& run) {
  const SightedSet rendered;
  const SightedSet& set = run.set() != nullptr ? *run.set() : rendered;
  std::string text = "scene_id,im_id,obj_id,score,R,t,time\n";
  for_each_pose(run, [&](const TrialRecord& trial, const Pose& cam_from_target) {
    const TrialName name = run.name_of(trial.trial);
    const Eigen::Matrix3d rotation = cam_from_target.rotation * set.target_from_model;
    const Eigen::Vector3d t_mm = kMillimetresPerMetre * cam_from_target.translation;
    text +=
        fmt::format("{},{},{},1,{},{},-1\n", name.scene_id, name.im_id, set.obj_id,
                    fmt::join(rows_of(rotation), " "), fmt::join(t_mm.begin(), t_mm.end(), " "));
  });
  return text;
}

std::string speed_lines(const ExportedRun& run, const std::filesystem::path& folder) {
  const SightedSet* const set = run.set();
  if (set == nullptr) {
    throw InputError(
        fmt::format("{}: its images have no names, which only a data set's have", folder.string()));
  }
  std::string text;
  for_each_pose(run, [&](const TrialRecord& trial, const Pose& cam_from_target) {
    const Sighting& sighting = run.images->sighting_of(trial.trial);
    const Eigen::Matrix3d rotation = cam_from_target.rotation * set->target_from_model;
    const Eigen::Vector3d& t = cam_from_target.translation;
    const Eigen::Vector4d q = quaternion_wxyz(rotation);
    text += fmt::format("{},{},{},{},{}\n", sighting.picture.filename().string(),
                        fmt::join(q.begin(), q.end(), ","), t.x(), t.y(), t.z());
  });
  return text;
}

// x, y, score of each feature of the target.
nlohmann::ordered_json keypoints_of(const ExportedRun& run, const TrialRecord& trial) {
  const EstimateRecord* const judge = find_estimate(trial, run.solver);
  nlohmann::ordered_json keypoints = nlohmann::ordered_json::array();
  for (const TargetFeature& feature : run.study.pose_study()->target->features) {
    const auto observations = trial.observations();
    const auto found = std::find_if(
        observations.begin(), observations.end(),
        [&](const ObservationRecord& o) { return o.feature == feature.name && o.is_found(); });
    const bool is_removed =
        judge != nullptr && std::find(judge->removed.begin(), judge->removed.end(), feature.name) !=
                                judge->removed.end();
    const bool counts = found != observations.end() && !is_removed;
    for (const double number :
         {counts ? found->pixel.x() : 0.0, counts ? found->pixel.y() : 0.0, counts ? 1.0 : 0.0}) {
      keypoints.push_back(number);
    }
  }
  return keypoints;
}

std::string coco_results(const ExportedRun& run) {
  nlohmann::ordered_json results = nlohmann::ordered_json::array();
  std::set<int> scenes;
  for_each_trial(run, [&](const TrialRecord& trial) {
    const TrialName name = run.name_of(trial.trial);
    scenes.insert(name.scene_id);
    if (scenes.size() > 1) {
      throw InputError(fmt::format(
          "the run is of several scenes ({}, ...), but COCO's results know an image by one number: "
          "say --scene which of them is to be written",
          fmt::join(scenes, ", ")));
    }
    results.push_back({{"image_id", name.im_id},
                       {"category_id", run.set() != nullptr ? run.set()->obj_id : 1},
                       {"keypoints", keypoints_of(run, trial)},
                       {"score", 1}});
  });
  return results.dump() + "\n";
}

}  // namespace

std::string export_run(const ExportRequest& request) {
  const ExportedRun run = open_run(request);
  switch (request.format) {
    case ExportFormat::kBop:
      return bop_lines(run);
    case ExportFormat::kSpeed:
      return speed_lines(run, request.run);
    case ExportFormat::kCoco:
      return coco_results(run);
  }
  return "";
}

}  // namespace sightline
