// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/scores.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/compare/measures.h"
#include "eval/compare/paired.h"
#include "eval/compare/settings.h"
#include "eval/compare/verdicts.h"
#include "eval/output/json.h"
#include "eval/score/targets_file.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

using TargetId = std::array<int64_t, 4>;
using Targets = std::map<TargetId, const TargetRow*>;

// One of the two that are compared.
struct ComparedScores {
  fs::path path;
  TargetsTable table;
  std::vector<std::string> methods;          // in the file's order
  std::map<std::string, Targets> targets{};  // by method
};

ComparedScores read_compared_scores(const fs::path& path) {
  ComparedScores scores;
  scores.path = path;
  scores.table = read_targets_csv(fs::is_directory(path) ? path / kTargetsFile : path);
  for (const TargetRow& row : scores.table.rows) {
    Targets& targets = scores.targets[row.method];
    if (targets.empty()) scores.methods.push_back(row.method);
    if (targets.emplace(row.id, &row).second) continue;
    throw InputError(fmt::format("{}: method {} has scene {} image {} object {} instance {} twice",
                                 path.string(), row.method, row.id[0], row.id[1], row.id[2],
                                 row.id[3]));
  }
  return scores;
}

// Where the folder has them; its scores are of other ones where it does not say.
std::optional<Settings> settings_of_scores(const fs::path& path) {
  const fs::path file = path / "scores.json";
  if (!fs::is_directory(path) || !fs::exists(file)) return std::nullopt;
  Settings settings;
  with_json(file, [&](const Json& json) {
    for (const char* key : {"dataset", "vsd_delta_mm"}) settings[key] = json.at(key).dump();
  });
  return settings;
}

std::string settings_of_both(const fs::path& base, const fs::path& now) {
  const auto before = settings_of_scores(base);
  const auto after = settings_of_scores(now);
  if (before && after) return settings_text(*before, *after);
  return fmt::format("settings: not known, as {} has no scores.json",
                     (before ? now : base).string());
}

// Files were written with the digits that read back the same, but sets may be converted.
bool is_same_target(const TargetRow& a, const TargetRow& b) {
  constexpr double kTolerance = 1e-6;
  return (a.true_t_mm - b.true_t_mm).norm() <= kTolerance * (1 + a.true_t_mm.norm());
}

// Rows of both for each target that both have.
using TargetPairs = std::vector<std::pair<const TargetRow*, const TargetRow*>>;

TargetPairs pairs_of(const ComparedScores& base, const std::string& base_method,
                     const ComparedScores& now, const std::string& now_method) {
  TargetPairs pairs;
  const Targets& of_now = now.targets.at(now_method);
  for (const auto& [id, row] : base.targets.at(base_method)) {
    const auto match = of_now.find(id);
    if (match == of_now.end()) continue;
    if (!is_same_target(*row, *match->second)) {
      throw InputError(
          fmt::format("{} and {}: scene {} image {} object {} instance {} is at another true "
                      "position in each; must be scores on one data set",
                      base.path.string(), now.path.string(), id[0], id[1], id[2], id[3]));
    }
    pairs.emplace_back(row, match->second);
  }
  return pairs;
}

// The place of a number in the rows; none where the file lacks it, or no target has it.
std::optional<size_t> place_of(const ComparedScores& scores, const TrialNumber& number) {
  const auto& names = scores.table.numbers;
  const auto found = std::find(names.begin(), names.end(), number.name);
  if (found == names.end()) return std::nullopt;
  const auto place = static_cast<size_t>(found - names.begin());
  bool has_estimates = false;
  for (const TargetRow& row : scores.table.rows) {
    const bool is_told = !std::isnan(row.numbers[place]);
    has_estimates = has_estimates || row.is_estimated;
    if (is_told && (row.is_estimated || std::isfinite(row.numbers[place]))) return place;
  }
  return has_estimates ? std::nullopt : std::optional(place);
}

Share share_of_target(const TrialNumber& number, const TargetRow& row,
                      std::optional<size_t> place) {
  if (!place) return {row.is_estimated ? 0.0 : 1.0};  // the rate of failures
  const double value = row.numbers[*place];
  if (std::isnan(value)) return {number.cap};
  return {std::min(value, number.cap)};
}

// What is compared, and by what.
struct ScorePair {
  const ComparedScores& base;
  const ComparedScores& now;
  std::vector<Measure> measures;
  double tolerance;
};

bool is_failure_rate(const Measure& measure) {
  return measure.number.name == "failure_rate";
}

CellDifference cell_of_pairs(const ScorePair& both, const std::string& condition,
                             const std::string& method, const TargetPairs& pairs) {
  CellDifference cell;
  cell.condition = condition;
  cell.solver = method;
  for (const Measure& measure : both.measures) {
    std::optional<size_t> base_place;
    std::optional<size_t> now_place;
    if (!is_failure_rate(measure)) {
      base_place = place_of(both.base, measure.number);
      now_place = place_of(both.now, measure.number);
    }
    PairedNumber numbers;
    for (const auto& [before, after] : pairs) {
      numbers.base.push_back(share_of_target(measure.number, *before, base_place));
      numbers.now.push_back(share_of_target(measure.number, *after, now_place));
    }
    cell.differences.push_back(paired_difference(measure, numbers, both.tolerance,
                                                 fmt::format("compare/{}/{}/", condition, method)));
  }
  return cell;
}

// The method of the new scores that stands against one of the base's.
std::optional<std::string> counterpart(const ScorePair& both, const std::string& method) {
  if (both.now.targets.contains(method)) return method;
  const bool are_single = both.base.methods.size() == 1 && both.now.methods.size() == 1;
  return are_single ? std::optional(both.now.methods.front()) : std::nullopt;
}

// All targets of a method, then those of each object where there are several.
void add_cells(const ScorePair& both, const std::string& method, Comparison& comparison,
               size_t& count) {
  const auto other = counterpart(both, method);
  const TargetPairs pairs = other ? pairs_of(both.base, method, both.now, *other) : TargetPairs{};
  const std::string name = !other || *other == method ? method : method + " to " + *other;
  if (pairs.empty()) {
    CellDifference& cell = comparison.cells.emplace_back();
    cell.condition = "all";
    cell.solver = name;
    cell.verdict = Verdict::kMissing;
    return;
  }
  count += pairs.size();
  comparison.cells.push_back(cell_of_pairs(both, "all", name, pairs));
  std::map<int, TargetPairs> by_object;
  for (const auto& pair : pairs) by_object[pair.first->id[2]].push_back(pair);
  if (by_object.size() < 2) return;
  for (const auto& [obj_id, of_object] : by_object) {
    comparison.cells.push_back(
        cell_of_pairs(both, fmt::format("object {}", obj_id), name, of_object));
  }
}

// Those that both can tell. One that somebody asks for must be among them.
std::vector<Measure> told_measures(const ComparedScores& base, const ComparedScores& now,
                                   const std::vector<std::string>& names) {
  std::vector<Measure> told;
  for (const Measure& measure : find_measures(names, Subject::kScores)) {
    const bool is_told = is_failure_rate(measure) ||
                         (place_of(base, measure.number) && place_of(now, measure.number));
    if (is_told) told.push_back(measure);
    if (is_told || names.empty()) continue;
    throw InputError(
        fmt::format("--measure {}: {} or {} does not tell it: it has no model or no "
                    "depth, or is of another version",
                    measure.name, base.path.string(), now.path.string()));
  }
  return told;
}

}  // namespace

bool is_of_scores(const fs::path& path) {
  return fs::is_directory(path) ? fs::exists(path / kTargetsFile) : path.extension() == ".csv";
}

Comparison compare_scores(const fs::path& base_path, const fs::path& now_path, double tolerance,
                          const std::vector<std::string>& measures) {
  const ComparedScores base = read_compared_scores(base_path);
  const ComparedScores now = read_compared_scores(now_path);
  const ScorePair both{base, now, told_measures(base, now, measures), tolerance};
  Comparison comparison;
  comparison.study = "scores";
  comparison.tolerance = tolerance;
  comparison.settings = settings_of_both(base_path, now_path);
  size_t paired = 0;
  for (const std::string& method : base.methods) add_cells(both, method, comparison, paired);
  if (paired == 0) {
    throw InputError(fmt::format("{} and {}: have no target and method in common; of {} and of {}",
                                 base_path.string(), now_path.string(),
                                 fmt::join(base.methods, ", "), fmt::join(now.methods, ", ")));
  }
  const size_t left_out = base.table.rows.size() - paired;
  comparison.how = fmt::format("paired: {} targets that are in both", paired);
  if (left_out > 0) {
    comparison.how += fmt::format("; {} of the base's are not in the new scores", left_out);
  }
  judge(comparison.cells);
  return comparison;
}

}  // namespace sightline
