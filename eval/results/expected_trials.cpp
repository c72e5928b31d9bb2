// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/results/expected_trials.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/study/study.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

struct NamedNumber {
  const char* name;
  double value;
};

// Why an error that counts in every mean is none; empty where it is one.
std::string why_no_error(const NamedNumber& number) {
  if (std::isfinite(number.value) && number.value >= 0) return "";
  return fmt::format("its {} is {}, must be a number from 0", number.name, number.value);
}

// These may be unknown (NaN: a target without a mesh) or boundless (a vertex behind the camera).
std::string why_no_distance(const NamedNumber& number) {
  if (!(number.value < 0)) return "";
  return fmt::format("its {} is {}, must not be below 0", number.name, number.value);
}

std::string why_no_count(const char* name, int count) {
  return count >= 0 ? "" : fmt::format("its {} is {}, must be from 0", name, count);
}

std::string first_of(std::initializer_list<std::string> problems) {
  const auto found = std::find_if(problems.begin(), problems.end(),
                                  [](const std::string& text) { return !text.empty(); });
  return found == problems.end() ? "" : *found;
}

bool is_finite(const Pose& pose) {
  return pose.rotation.allFinite() && pose.translation.allFinite();
}

std::string why_wrong(const EstimateRecord& e) {
  const std::string counts = first_of({why_no_count("false_removals", e.false_removals),
                                       why_no_count("missed_outliers", e.missed_outliers)});
  if (!counts.empty() || !e.is_ok()) return counts;
  if (!is_finite(e.cam_from_target)) return "its pose has what is no finite number";
  return first_of({why_no_error({"theta_error_deg", e.theta_error_deg}),
                   why_no_error({"t_error_percent", e.t_error_percent}),
                   why_no_error({"geodesic_deg", e.geodesic_deg}),
                   why_no_distance({"reprojection_rms_px", e.reprojection_rms_px}),
                   why_no_distance({"add_m", e.add_m}), why_no_distance({"mssd_m", e.mssd_m}),
                   why_no_distance({"mspd_px", e.mspd_px})});
}

std::string why_wrong(const OrientationRecord& o) {
  return first_of({why_no_count("failures", o.failures),
                   why_no_error({"angle_error_deg", o.angle_error_deg}),
                   why_no_error({"theta_error_deg", o.theta_error_deg}),
                   why_no_error({"geodesic_deg", o.geodesic_deg}),
                   why_no_error({"t_error_percent", o.t_error_percent})});
}

std::string why_wrong(const ObservationRecord& o) {
  if (!o.is_found() || o.pixel.allFinite()) return "";
  return "is found, but at no finite pixel";
}

std::string why_wrong(const LineRecord& line) {
  const bool is_line = line.pixel.allFinite() && line.direction.allFinite() &&
                       line.direction.squaredNorm() > 0 && line.offset_variance_px2 > 0 &&
                       line.slope_variance > 0 && line.edge >= 0;
  return is_line ? "" : "has a line without a place, a direction or noise";
}

// Records by their names, which must be the expected ones in their order.
template <typename Record>
std::string why_wrong(std::span<const Record> records, const std::string Record::*name,
                      const std::vector<std::string>& expected, const char* what) {
  const bool are_they =
      std::equal(records.begin(), records.end(), expected.begin(), expected.end(),
                 [&](const Record& record, const std::string& n) { return record.*name == n; });
  if (!are_they) {
    std::vector<std::string> there;
    for (const Record& record : records) there.push_back(record.*name);
    return fmt::format("has {} of '{}', must have those of '{}'", what, fmt::join(there, ", "),
                       fmt::join(expected, ", "));
  }
  for (const Record& record : records) {
    const std::string problem = why_wrong(record);
    if (!problem.empty()) return fmt::format("{}: {}", record.*name, problem);
  }
  return "";
}

std::string why_wrong(const TrialRecord& trial, const ExpectedTrials& expected) {
  const int64_t condition = trial.trial % expected.conditions;
  if (trial.condition != condition) {
    return fmt::format("its condition is {}, must be {}", trial.condition, condition);
  }
  if (trial.redraws < 0) return why_no_count("redraws", trial.redraws);
  if (!trial.orientations().empty()) {
    if (!is_finite(trial.true_cam_from_target)) return "its true pose is not finite";
    return why_wrong(trial.orientations(), &OrientationRecord::method, expected.solvers, "methods");
  }
  const auto estimates = trial.estimates();
  std::string problem =
      why_wrong(estimates, &EstimateRecord::solver, expected.solvers, "estimates");
  if (!problem.empty()) return problem;
  const bool has_pose = std::any_of(estimates.begin(), estimates.end(),
                                    [](const EstimateRecord& e) { return e.is_ok(); });
  if (has_pose && !is_finite(trial.true_cam_from_target)) return "its true pose is not finite";
  for (const LineRecord& line : trial.lines()) {
    problem = why_wrong(line);
    if (!problem.empty()) return fmt::format("{}: {}", line.feature, problem);
  }
  if (trial.observations().empty() || expected.features.empty()) return "";
  return why_wrong(trial.observations(), &ObservationRecord::feature, expected.features,
                   "observations");
}

// Goes along with the trials of a store, whose numbers only grow.
class TrialCheck {
 public:
  TrialCheck(const Store& store, const ExpectedTrials& expected)
      : file_(store.file()), expected_(expected), next_(expected.shard.index) {}

  void check(const TrialRecord& trial) {
    const int64_t number = trial.trial;
    if (number < 0 || number >= expected_.count) {
      fail(fmt::format("has a trial {}, must be from 0 to {}", number, expected_.count - 1));
    }
    if (number % expected_.shard.count != expected_.shard.index) {
      fail(fmt::format("has trial {}, which is not of shard {} of {}", number,
                       expected_.shard.index, expected_.shard.count));
    }
    if (number != next_) fail_as_missing();
    next_ += expected_.shard.count;
    const std::string problem = why_wrong(trial, expected_);
    if (!problem.empty()) fail(fmt::format("trial {}: {}", number, problem));
  }

  void finish() const {
    if (next_ < expected_.count) fail_as_missing();
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw InputError(fmt::format("{}: {}", file_.string(), problem));
  }
  [[noreturn]] void fail_as_missing() const {
    fail(fmt::format("lacks trial {}; must hold every trial of shard {} of {}", next_,
                     expected_.shard.index, expected_.shard.count));
  }

  const std::filesystem::path& file_;
  const ExpectedTrials& expected_;
  int64_t next_;
};

// The whole where the store names none.
Shard shard_of(const Store& store, const std::map<std::string, std::string>& meta) {
  const auto found = meta.find("shard");
  if (found == meta.end()) return {};
  try {
    return read_shard(found->second, [](const char*) -> const char* { return nullptr; }).shard;
  } catch (const InputError&) {
    throw InputError(fmt::format("{}: is shard '{}', must be I/N", store.file().string(),
                                 found->second.substr(0, 40)));
  }
}

}  // namespace

ExpectedTrials expected_trials(const Study& study, const Store& store) {
  ExpectedTrials expected{.count = study.trial_count(),
                          .shard = shard_of(store, store.meta()),
                          .conditions = static_cast<int64_t>(study.conditions.size()),
                          .solvers = study.solver_names()};
  if (const PoseStudy* const poses = study.pose_study()) {
    for (int slot = 0; slot < static_cast<int>(poses->features.size()); ++slot) {
      expected.features.push_back(poses->feature(slot).name);
    }
  }
  return expected;
}

ExpectedTrials expected_trials(const Store& store, int64_t conditions,
                               std::vector<std::string> solvers) {
  const auto meta = store.meta();
  const auto count = meta.find("trials");
  const std::string text = count == meta.end() ? "" : count->second;
  const bool is_number =
      !text.empty() && text.size() < 18 &&
      std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (!is_number) {
    throw InputError(fmt::format("{}: says that it is of '{}' trials, must be a whole number",
                                 store.file().string(), text.substr(0, 40)));
  }
  if (conditions < 1) {
    throw InputError(
        fmt::format("{}: its summary speaks of no condition", store.file().string()));
  }
  return {.count = std::stoll(text),
          .shard = shard_of(store, meta),
          .conditions = conditions,
          .solvers = std::move(solvers)};
}

NextTrial checked_reader(const Store& store, const ExpectedTrials& expected) {
  const auto check = std::make_shared<TrialCheck>(store, expected);
  return [next = store.reader(), check] {
    std::optional<TrialRecord> trial = next();
    trial ? check->check(*trial) : check->finish();
    return trial;
  };
}

}  // namespace sightline
