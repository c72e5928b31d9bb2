// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/pairing.h"

#include <algorithm>

#include <fmt/format.h>

#include "eval/results/expected_trials.h"
#include "eval/results/store.h"
#include "scenes/files/input_error.h"
#include "scenes/files/input_file.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

using Numbers = std::vector<const RunNumber*>;

// The numbers that the measures are made of, each once.
Numbers needed_numbers(std::span<const Measure> measures) {
  Numbers needed;
  for (const RunNumber& number : run_numbers()) {
    const bool is_needed = std::any_of(measures.begin(), measures.end(), [&](const Measure& m) {
      return m.number.name == number.name;
    });
    if (is_needed) needed.push_back(&number);
  }
  return needed;
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

void add_shares(const RunNumber& number, const Share& base, const Share& now, PairedCell& cell) {
  PairedNumber& pairs = cell[number.name];
  pairs.base.push_back(base);
  pairs.now.push_back(now);
}

// Of what both have made of the trial: records of solvers or of methods.
template <typename Record>
const Record* find_record(std::span<const Record> records, const std::string Record::*name,
                          const std::string& wanted) {
  const auto found = std::find_if(records.begin(), records.end(),
                                  [&](const Record& record) { return record.*name == wanted; });
  return found == records.end() ? nullptr : &*found;
}

void add_estimates(const TrialRecord& base, const TrialRecord& now, const Numbers& numbers,
                   const std::string& condition, std::map<CellKey, PairedCell>& cells) {
  for (const EstimateRecord& before : base.estimates()) {
    const auto* after = find_record(now.estimates(), &EstimateRecord::solver, before.solver);
    if (after == nullptr) continue;
    PairedCell& cell = cells[{condition, before.solver}];
    for (const RunNumber* number : numbers) {
      if (!number->of_estimate) continue;
      add_shares(*number, number->of_estimate(base, before), number->of_estimate(now, *after),
                 cell);
    }
  }
}

void add_orientations(const TrialRecord& base, const TrialRecord& now, const Numbers& numbers,
                      const std::string& condition, std::map<CellKey, PairedCell>& cells) {
  for (const OrientationRecord& before : base.orientations()) {
    const auto* after = find_record(now.orientations(), &OrientationRecord::method, before.method);
    if (after == nullptr) continue;
    PairedCell& cell = cells[{condition, before.method}];
    for (const RunNumber* number : numbers) {
      if (!number->of_orientation) continue;
      add_shares(*number, number->of_orientation(before), number->of_orientation(*after), cell);
    }
  }
}

void add_features(const TrialRecord& base, const TrialRecord& now, const Numbers& numbers,
                  const std::string& condition, std::map<CellKey, PairedCell>& cells) {
  for (const RunNumber* number : numbers) {
    if (!number->of_features) continue;
    add_shares(*number, number->of_features(base), number->of_features(now),
               cells[{condition, kFeatures}]);
  }
}

void add_pair(const TrialRecord& base, const TrialRecord& now, const Numbers& numbers,
              const std::string& condition, std::map<CellKey, PairedCell>& cells) {
  add_estimates(base, now, numbers, condition, cells);
  add_orientations(base, now, numbers, condition, cells);
  add_features(base, now, numbers, condition, cells);
}

std::string condition_of(const ComparedRun& run, const TrialRecord& trial) {
  const auto index = static_cast<size_t>(trial.condition);
  return index < run.conditions.size() ? run.conditions[index] : "";
}

// The trials of a run, each checked against what its summary speaks of.
class TrialsOfRun {
 public:
  explicit TrialsOfRun(const ComparedRun& run)
      : store_(Store::open(*run.store)),
        expected_(expected_trials(store_, static_cast<int64_t>(run.conditions.size()),
                                  solvers_of(run.summary))),
        next_(checked_reader(store_, expected_)) {}
  TrialsOfRun(const TrialsOfRun&) = delete;
  TrialsOfRun& operator=(const TrialsOfRun&) = delete;

  std::optional<TrialRecord> next() const { return next_(); }

 private:
  // Every condition has the same: those of the first.
  static std::vector<std::string> solvers_of(const Json& summary) {
    std::vector<std::string> solvers;
    const Json& cells = summary.at("cells");
    for (const Json& cell : cells) {
      if (cell.at("condition") != cells.front().at("condition")) break;
      solvers.push_back(text_in(cell, "solver"));
    }
    return solvers;
  }

  Store store_;
  ExpectedTrials expected_;
  NextTrial next_;
};

// The store's own is surely of its trials; a summary.json alone may have the file beside it.
std::optional<std::string> study_as_run(const ComparedRun& run, const fs::path& file) {
  if (run.store) {
    const std::map<std::string, std::string> meta = Store::open(*run.store).meta();
    const auto text = meta.find("study_toml");
    if (text != meta.end()) return text->second;
  }
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  return read_input_file(file, kMostTextBytes);
}

}  // namespace

Subject ComparedRun::subject() const {
  const Json& cells = summary.at("cells");
  const bool is_orientation = !cells.empty() && cells.front().contains("copies");
  return is_orientation ? Subject::kOrientations : Subject::kPoses;
}

std::string condition_name(const Json& condition) {
  std::string name;
  for (const auto& [key, value] : condition.items()) {
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    name += fmt::format("{}{} {}", name.empty() ? "" : ", ", key, text);
  }
  return name.empty() ? "all" : name;
}

// A gate that is given numbers that cannot be must not pass for it: a cell's counts must count, and
// of trials there are means.
void require_sound(const Json& cell) {
  const int trials = whole_in(cell, "trials");
  if (trials < 0) throw InputError(fmt::format("trials is {}, must be from 0", trials));
  if (cell.contains("failures")) {
    const int failures = whole_in(cell, "failures");
    if (failures < 0 || failures > trials) {
      throw InputError(fmt::format("failures is {}, must be from 0 to {}", failures, trials));
    }
  }
  for (const auto& [key, value] : cell.items()) {
    if (trials == 0 || key == "nees" || !value.is_object() || !value.contains("mean")) continue;
    if (value.at("mean").is_number() && value.at("mean").get<double>() >= 0) continue;
    throw InputError(fmt::format("{}.mean is {}, must be a number from 0", key,
                                 value.at("mean").dump().substr(0, 40)));
  }
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
  try {
    run.summary = read_json(file);
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("{}: not a summary.json of sightline's ({})", path.string(), error.what()));
  }
  try {
    for (const Json& cell : run.summary.at("cells")) {
      require_sound(cell);
      const std::string name = condition_name(cell.at("condition"));
      const bool is_known =
          std::find(run.conditions.begin(), run.conditions.end(), name) != run.conditions.end();
      if (!is_known) run.conditions.push_back(name);
    }
    run.summary.at("study").get<std::string>();
    run.summary.at("seed").get<uint64_t>();
  } catch (const nlohmann::json::exception&) {
    throw InputError(fmt::format("{}: not a summary.json of sightline's", file.string()));
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("{}: not a summary.json of sightline's ({})", file.string(), error.what()));
  }
  const fs::path store = path / "results.sqlite";
  if (is_folder && fs::is_regular_file(store)) run.store = store;
  run.toml = study_as_run(run, file.parent_path() / "study.toml");
  return run;
}

Pairs pair_trials(const ComparedRun& base, const ComparedRun& now,
                  std::span<const Measure> measures) {
  const Numbers numbers = needed_numbers(measures);
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
  // Side by side, one trial of each in memory: a run may have millions.
  const TrialsOfRun of_base(base);
  const TrialsOfRun of_now(now);
  auto match = of_now.next();
  for (auto trial = of_base.next(); trial; trial = of_base.next()) {
    while (match && match->trial < trial->trial) match = of_now.next();
    if (!match) break;
    if (match->trial != trial->trial) {
      ++pairs.left_out;
      continue;
    }
    const std::string condition = condition_of(base, *trial);
    if (condition != condition_of(now, *match) || !has_same_truth(*trial, *match)) {
      return {{}, 0, 0, fmt::format("trial {} is another draw in each", trial->trial)};
    }
    add_pair(*trial, *match, numbers, condition, pairs.cells);
    ++pairs.count;
  }
  if (pairs.count == 0) pairs.why_not = "they have no trial in common";
  return pairs;
}

}  // namespace sightline
