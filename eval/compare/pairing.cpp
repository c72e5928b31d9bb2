// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/pairing.h"

#include <algorithm>
#include <fstream>
#include <string_view>

#include <fmt/format.h>

#include "eval/results/store.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// What a solver or method made of a trial.
struct TrialErrors {
  std::string_view solver;
  bool is_failed = false;
  std::array<double, kComparedErrors.size()> errors{};  // capped
};

std::vector<TrialErrors> errors_of(const TrialRecord& trial) {
  std::vector<TrialErrors> all;
  const auto capped = [](double error, double cap) { return error < cap ? error : cap; };
  for (const EstimateRecord& estimate : trial.estimates()) {
    TrialErrors& of_solver = all.emplace_back();
    of_solver.solver = estimate.solver;
    of_solver.is_failed = !estimate.is_ok();
    for (size_t i = 0; i < kComparedErrors.size(); ++i) {
      const double error = estimate.*kComparedErrors[i].of_estimate;
      of_solver.errors[i] =
          of_solver.is_failed ? kComparedErrors[i].cap : capped(error, kComparedErrors[i].cap);
    }
  }
  for (const OrientationRecord& orientation : trial.orientations()) {
    TrialErrors& of_method = all.emplace_back();
    of_method.solver = orientation.method;
    of_method.is_failed = orientation.failures > 0;
    for (size_t i = 0; i < kComparedErrors.size(); ++i) {
      of_method.errors[i] =
          capped(orientation.*kComparedErrors[i].of_orientation, kComparedErrors[i].cap);
    }
  }
  return all;
}

// The same draw: other machines may differ in the last digits.
bool has_same_truth(const TrialRecord& a, const TrialRecord& b) {
  constexpr double kTolerance = 1e-9;
  const Pose& pose_a = a.true_cam_from_target;
  const Pose& pose_b = b.true_cam_from_target;
  return (pose_a.rotation - pose_b.rotation).norm() < kTolerance &&
         (pose_a.translation - pose_b.translation).norm() <=
             kTolerance * (1 + pose_a.translation.norm());
}

void add_pair(const TrialRecord& base, const TrialRecord& now, const std::string& condition,
              std::map<CellKey, PairedCell>& cells) {
  const std::vector<TrialErrors> all_now = errors_of(now);
  for (const TrialErrors& before : errors_of(base)) {
    const auto after = std::find_if(all_now.begin(), all_now.end(), [&](const TrialErrors& e) {
      return e.solver == before.solver;
    });
    if (after == all_now.end()) continue;
    PairedCell& cell = cells[{condition, std::string(before.solver)}];
    for (size_t i = 0; i < kComparedErrors.size(); ++i) {
      cell.base[i].push_back(before.errors[i]);
      cell.differences[i].push_back(after->errors[i] - before.errors[i]);
    }
    cell.failures.push_back(int{after->is_failed} - int{before.is_failed});
    cell.base_failures += before.is_failed;
    cell.now_failures += after->is_failed;
  }
}

std::string condition_of(const ComparedRun& run, const TrialRecord& trial) {
  const auto index = static_cast<size_t>(trial.condition);
  return index < run.conditions.size() ? run.conditions[index] : "";
}

}  // namespace

std::string condition_name(const Json& condition) {
  std::string name;
  for (const auto& [key, value] : condition.items()) {
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    name += fmt::format("{}{} {}", name.empty() ? "" : ", ", key, text);
  }
  return name.empty() ? "all" : name;
}

ComparedRun read_compared_run(const fs::path& path) {
  ComparedRun run;
  run.path = path;
  const bool is_folder = fs::is_directory(path);
  const fs::path file = is_folder ? path / "summary.json" : path;
  if (!fs::is_regular_file(file)) {
    throw InputError(fmt::format("{}: {}", path.string(),
                                 is_folder ? "holds no summary.json; must be the folder of a run"
                                           : "no such file or folder"));
  }
  std::ifstream stream(file, std::ios::binary);
  run.summary = Json::parse(stream, nullptr, /*allow_exceptions=*/false);
  try {
    for (const Json& cell : run.summary.at("cells")) {
      const std::string name = condition_name(cell.at("condition"));
      const bool is_known =
          std::find(run.conditions.begin(), run.conditions.end(), name) != run.conditions.end();
      if (!is_known) run.conditions.push_back(name);
    }
    run.summary.at("study").get<std::string>();
    run.summary.at("seed").get<uint64_t>();
  } catch (const nlohmann::json::exception&) {
    throw InputError(fmt::format("{}: not a summary.json of sightline's", file.string()));
  }
  const fs::path store = path / "results.sqlite";
  if (is_folder && fs::is_regular_file(store)) run.store = store;
  return run;
}

Pairs pair_trials(const ComparedRun& base, const ComparedRun& now) {
  Pairs pairs;
  for (const ComparedRun* run : {&base, &now}) {
    if (run->store) continue;
    pairs.why_not = fmt::format("{} has no results.sqlite", run->path.string());
    return pairs;
  }
  if (base.summary.at("seed") != now.summary.at("seed")) {
    pairs.why_not = fmt::format("the seeds are {} and {}", base.summary.at("seed").dump(),
                                now.summary.at("seed").dump());
    return pairs;
  }
  const std::vector<TrialRecord> of_base = Store::open(*base.store).trials();
  const std::vector<TrialRecord> of_now = Store::open(*now.store).trials();
  auto match = of_now.begin();
  for (const TrialRecord& trial : of_base) {
    while (match != of_now.end() && match->trial < trial.trial) ++match;
    if (match == of_now.end()) break;
    if (match->trial != trial.trial) {
      ++pairs.left_out;
      continue;
    }
    const std::string condition = condition_of(base, trial);
    if (condition != condition_of(now, *match) || !has_same_truth(trial, *match)) {
      return {{}, 0, 0, fmt::format("trial {} is another draw in each", trial.trial)};
    }
    add_pair(trial, *match, condition, pairs.cells);
    ++pairs.count;
  }
  if (pairs.count == 0) pairs.why_not = "they have no trial in common";
  return pairs;
}

}  // namespace sightline
