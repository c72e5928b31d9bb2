// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/doors/estimate_file.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/datasets/bop/results_csv.h"
#include "eval/datasets/conventions.h"
#include "eval/datasets/picture_names.h"
#include "eval/datasets/speed/results_csv.h"
#include "eval/output/csv_reader.h"
#include "eval/output/numbers.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// What a file has for one trial.
struct GivenEstimate {
  EstimateOutcome outcome = EstimateOutcome::kOk;
  Pose cam_from_target;
  std::optional<Matrix6d> covariance;  // of (w, dt), radians and metres
  std::vector<std::string> removed;
};

// Which trial an estimate is of: its number in files of our own, otherwise its picture.
using TrialKey = std::tuple<int64_t, int64_t, int>;
using GivenEstimates = std::map<TrialKey, GivenEstimate>;

TrialKey key_of_picture(const TrialName& trial) {
  return {trial.scene_id, trial.im_id, trial.gt_id};
}

TrialKey key_of_number(const TrialName& trial) {
  return {trial.trial, 0, 0};
}

// ---- results of BOP

// The covariance of (w, dt) in the target's frame is the one in the model's: both are turned from
// the camera's side.
GivenEstimates read_bop(const EstimateSource& source, const SightedSet* set) {
  const SightedSet rendered;
  const SightedSet& names = set != nullptr ? *set : rendered;
  std::vector<BopEstimate> estimates = read_bop_results(source.file);
  std::erase_if(estimates, [&](const BopEstimate& e) { return e.obj_id != names.obj_id; });
  std::stable_sort(estimates.begin(), estimates.end(),
                   [](const auto& a, const auto& b) { return a.score > b.score; });
  std::vector<PlaceInImage> places;
  std::vector<double> scores;
  std::vector<GivenEstimate> given;
  for (const BopEstimate& e : estimates) {
    given.push_back({e.problem.empty() ? EstimateOutcome::kOk : EstimateOutcome::kNotRigid,
                     pose_in_metres(e, names.target_from_model), e.covariance_rad_m, e.removed});
    places.push_back({e.scene_id, e.im_id, given.back().cam_from_target.translation});
    scores.push_back(e.score);
  }
  GivenEstimates by_trial;
  const std::vector<int> chosen = set != nullptr ? sightings_of(places, scores, set->sightings)
                                                 : std::vector<int>(given.size(), 0);
  for (size_t i = 0; i < given.size(); ++i) {
    if (chosen[i] < 0) continue;
    const int gt_id = set != nullptr ? set->sightings[static_cast<size_t>(chosen[i])].gt_id : 0;
    by_trial.emplace(TrialKey{places[i].scene_id, places[i].im_id, gt_id}, std::move(given[i]));
  }
  return by_trial;
}

// ---- ESA's challenges

GivenEstimates read_speed(const EstimateSource& source, const SightedSet* set) {
  if (set == nullptr) {
    throw InputError(fmt::format("{}: names pictures by their files, which only a data set has",
                                 source.file.string()));
  }
  PictureNames sightings;
  for (size_t i = 0; i < set->sightings.size(); ++i) {
    sightings.add(set->sightings[i].picture, static_cast<int>(i));
  }
  GivenEstimates by_trial;
  const std::vector<SpeedEstimate> estimates = read_speed_results(source.file);
  const auto found = pictures_of(estimates, sightings, source.file);
  for (size_t i = 0; i < estimates.size(); ++i) {
    const SpeedEstimate& estimate = estimates[i];
    if (!found[i]) {
      throw InputError(fmt::format("{}: line {} is about '{}', which the set does not have",
                                   source.file.string(), estimate.line, estimate.picture));
    }
    GivenEstimate given;
    if (!estimate.problem.empty()) given.outcome = EstimateOutcome::kNotRigid;
    given.cam_from_target = {estimate.cam_from_model.rotation * set->target_from_model.transpose(),
                             estimate.cam_from_model.translation};
    const Sighting& sighting = set->sightings[static_cast<size_t>(*found[i])];
    by_trial.emplace(TrialKey{sighting.scene_id, sighting.im_id, sighting.gt_id}, given);
  }
  return by_trial;
}

// ---- results of ours

// The solver that is meant: the one of the source's name, or the only one.
std::string solver_in(const EstimateSource& source) {
  std::set<std::string> solvers;
  for (CsvReader csv(source.file); csv.next();) solvers.emplace(csv.text("solver"));
  if (solvers.contains(source.name)) return source.name;
  if (solvers.size() == 1) return *solvers.begin();
  throw InputError(fmt::format("{}: has estimates of {}; the name must say which are meant",
                               source.file.string(), fmt::join(solvers, ", ")));
}

// The pose of a row; none where its numbers are not finite or no rotation.
std::optional<Pose> pose_in(const CsvReader& csv) {
  const auto number = [&csv](const char* column) {
    return csv.number_or(column, std::numeric_limits<double>::quiet_NaN());
  };
  const auto rotation =
      usable_rotation(Eigen::Quaterniond(number("qw"), number("qx"), number("qy"), number("qz")));
  const Eigen::Vector3d translation(number("tx_m"), number("ty_m"), number("tz_m"));
  if (!rotation || !translation.allFinite()) return std::nullopt;
  return Pose{*rotation, translation};
}

GivenEstimates read_results(const EstimateSource& source) {
  const std::string solver = solver_in(source);
  GivenEstimates by_trial;
  for (CsvReader csv(source.file); csv.next();) {
    if (csv.text("solver") != solver) continue;
    GivenEstimate given;
    try {
      given.outcome = from_string<EstimateOutcome>(csv.text("status"));
    } catch (const UnknownName& error) {
      csv.fail(fmt::format("has a status that {}", error.what()));
    }
    if (given.outcome == EstimateOutcome::kOk) {
      const std::optional<Pose> pose = pose_in(csv);
      if (!pose) given.outcome = EstimateOutcome::kNotRigid;
      given.cam_from_target = pose.value_or(Pose{});
      given.removed = csv.names("removed");
    }
    if (!by_trial.emplace(TrialKey{csv.whole("trial"), 0, 0}, given).second) {
      csv.fail(fmt::format("has trial {} of {} a second time", csv.text("trial"), solver));
    }
  }
  return by_trial;
}

// ---- which of them

EstimateFormat format_of(const EstimateSource& source) {
  if (source.format != EstimateFormat::kByHeader) return source.format;
  const CsvReader csv(source.file);
  if (csv.has_column("scene_id") && csv.has_column("R")) return EstimateFormat::kBop;
  constexpr size_t kBopFields = 7;  // of which a file without a header has a scene first
  if (csv.columns().size() == kBopFields && parsed_number(csv.columns().front())) {
    return EstimateFormat::kBop;
  }
  if (csv.has_column("trial") && csv.has_column("solver")) return EstimateFormat::kSightline;
  constexpr size_t kSpeedFields = 8;
  if (csv.columns().size() == kSpeedFields) return EstimateFormat::kSpeed;
  csv.fail(
      "begins no file of estimates: BOP's results, a run's results.csv, or lines of filename, "
      "q0, q1, q2, q3, x, y, z");
}

SolverAnswer answer(const GivenEstimates& given, const TrialKey& key,
                    const SolverQuestion& question) {
  const auto found = given.find(key);
  if (found == given.end()) return {EstimateOutcome::kNoEstimate, {}};
  SolverAnswer out{found->second.outcome, {}};
  out.estimate.status = PoseStatus::kOk;
  out.estimate.cam_from_target = found->second.cam_from_target;
  out.estimate.covariance = found->second.covariance;
  for (size_t i = 0; i < question.features.size(); ++i) {
    const auto& removed = found->second.removed;
    if (std::find(removed.begin(), removed.end(), question.features[i]) != removed.end()) {
      out.estimate.removed.push_back(static_cast<int>(i));
    }
  }
  return out;
}

}  // namespace

std::vector<Key> keys_of(EstimateSource& source) {
  const std::string table = "estimates";
  return {
      {.table = table,
       .name = "name",
       .value = &source.name,
       .allowed = {},
       .unit = "",
       .meaning = "of the solver that the file stands for",
       .is_required = true},
      {.table = table,
       .name = "file",
       .value = &source.file,
       .allowed = {},
       .unit = "",
       .meaning = "poses of somebody's pipeline: BOP results CSV, the CSV of ESA's challenges, or "
                  "results.csv of a run",
       .is_required = true},
      {.table = table,
       .name = "format",
       .value = choice(source.format, {{"by_header", EstimateFormat::kByHeader},
                                       {"bop", EstimateFormat::kBop},
                                       {"speed", EstimateFormat::kSpeed},
                                       {"sightline", EstimateFormat::kSightline}}),
       .allowed = {},
       .unit = "",
       .meaning = "of the file, which its first line tells otherwise"},
  };
}

TrialSolver recorded_solver(const EstimateSource& source, const SightedSet* set) {
  const EstimateFormat format = format_of(source);
  GivenEstimates read;
  if (format == EstimateFormat::kBop) read = read_bop(source, set);
  if (format == EstimateFormat::kSpeed) read = read_speed(source, set);
  if (format == EstimateFormat::kSightline) read = read_results(source);
  if (read.empty()) {
    throw InputError(fmt::format("{}: has no pose of the target in a picture of the study",
                                 source.file.string()));
  }
  const auto key_of = format == EstimateFormat::kSightline ? key_of_number : key_of_picture;
  TrialSolver solver;
  solver.name = source.name;
  solver.summary = fmt::format("estimates from {}", source.file.filename().string());
  const auto failed = std::count_if(read.begin(), read.end(), [](const auto& entry) {
    return entry.second.outcome == EstimateOutcome::kNotRigid;
  });
  if (failed > 0) {
    solver.summary += fmt::format(", of which {} {} no pose", failed, failed == 1 ? "is" : "are");
  }
  solver.is_recorded = true;
  solver.solve = [given = std::make_shared<const GivenEstimates>(std::move(read)),
                  key_of](const SolverQuestion& question) {
    return answer(*given, key_of(question.trial), question);
  };
  return solver;
}

}  // namespace sightline
