// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/compare.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "eval/compare/measures.h"
#include "eval/compare/paired.h"
#include "eval/compare/pairing.h"
#include "eval/compare/scores.h"
#include "eval/compare/settings.h"
#include "eval/compare/stored.h"
#include "eval/compare/verdicts.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// Both runs, and by what they are compared.
struct Runs {
  const ComparedRun& base;
  const ComparedRun& now;
  const Pairs& pairs;
  std::vector<Measure> measures;
  bool are_chosen;  ///< by somebody, who must know of one that the runs do not tell
  double tolerance;
};

const Json* find_cell(const Json& summary, const CellKey& key) {
  for (const Json& cell : summary.at("cells")) {
    const bool is_it =
        condition_name(cell.at("condition")) == key.first && cell.at("solver") == key.second;
    if (is_it) return &cell;
  }
  return nullptr;
}

bool has_trials(const Json& cell) {
  return cell.at("trials").get<int64_t>() > 0;
}

// What a summary says of a condition's features; null where it says nothing.
Json features_in(const Json& summary, const std::string& condition) {
  if (!summary.contains("extraction")) return nullptr;
  const Json& observations = summary.at("observations");
  for (size_t i = 0; i < observations.size(); ++i) {
    if (condition_name(observations[i].at("condition")) != condition) continue;
    Json cell = summary.at("extraction").at(i);
    cell["trials"] = observations[i].at("trials");
    return cell;
  }
  return nullptr;
}

// How the trials of both runs were matched, as a sentence's end.
std::string how_text(const Pairs& pairs) {
  if (!pairs.why_not.empty()) {
    return fmt::format("not paired, but by the intervals of each, as {}", pairs.why_not);
  }
  const std::string left_out =
      pairs.left_out == 0
          ? ""
          : fmt::format("; {} of the base's are left out of the new run's", pairs.left_out);
  return fmt::format("paired: {} trials of the same number and true pose in both{}", pairs.count,
                     left_out);
}

void require_told(const Runs& runs, const Measure& measure) {
  if (!runs.are_chosen) return;
  throw InputError(
      fmt::format("--measure {}: the summary of {} or {} does not tell it; it needs the trials "
                  "(results.sqlite) of both runs, on the same draws",
                  measure.name, runs.base.path.string(), runs.now.path.string()));
}

// The measures of a cell: of its pairs, or else of what `stored` has.
template <typename Stored>
std::vector<Difference> differences_of(const Runs& runs, const CellKey& key, bool are_of_features,
                                       const Stored& stored) {
  std::vector<Difference> differences;
  for (const Measure& measure : runs.measures) {
    if (measure.number.is_of_features != are_of_features) continue;
    if (runs.pairs.count > 0) {
      differences.push_back(
          paired_difference(measure, runs.pairs.cells.at(key).at(measure.number.name),
                            runs.tolerance, fmt::format("compare/{}/{}/", key.first, key.second)));
    } else if (const std::optional<Difference> difference = stored(measure)) {
      differences.push_back(*difference);
    } else {
      require_told(runs, measure);
    }
  }
  return differences;
}

// One cell of the base beside the same of the new run, before its p-values are adjusted.
CellDifference cell_difference(const Runs& runs, const Json& cell) {
  CellDifference result;
  result.condition = condition_name(cell.at("condition"));
  result.solver = cell.at("solver").get<std::string>();
  const CellKey key{result.condition, result.solver};
  const Json* const counterpart = find_cell(runs.now.summary, key);
  const bool is_missing = counterpart == nullptr || !has_trials(*counterpart) ||
                          (runs.pairs.count > 0 && !runs.pairs.cells.contains(key));
  if (is_missing) {
    result.verdict = Verdict::kMissing;
    return result;
  }
  result.differences =
      differences_of(runs, key, /*are_of_features=*/false, [&](const Measure& measure) {
        return stored_difference(measure, cell, *counterpart, runs.tolerance);
      });
  return result;
}

// The same of the features of a condition.
CellDifference feature_difference(const Runs& runs, const std::string& condition) {
  CellDifference result;
  result.condition = condition;
  result.solver = kFeatures;
  const CellKey key{condition, kFeatures};
  if (runs.pairs.count > 0 && !runs.pairs.cells.contains(key)) {
    result.verdict = Verdict::kMissing;
    return result;
  }
  const Json base = features_in(runs.base.summary, condition);
  const Json now = features_in(runs.now.summary, condition);
  result.differences =
      differences_of(runs, key, /*are_of_features=*/true,
                     [&](const Measure& measure) -> std::optional<Difference> {
                       if (base.is_null() || now.is_null()) return std::nullopt;
                       return stored_feature_difference(measure, base, now, runs.tolerance);
                     });
  return result;
}

std::vector<CellDifference> cell_differences(const Runs& runs) {
  std::vector<CellDifference> cells;
  const auto is_of_features = [](const Measure& m) { return m.number.is_of_features; };
  const bool has_features = std::any_of(runs.measures.begin(), runs.measures.end(), is_of_features);
  const bool has_others = !std::all_of(runs.measures.begin(), runs.measures.end(), is_of_features);
  std::vector<std::string> conditions;
  for (const Json& cell : runs.base.summary.at("cells")) {
    if (!has_trials(cell)) continue;
    if (has_others) cells.push_back(cell_difference(runs, cell));
    const std::string condition = condition_name(cell.at("condition"));
    if (conditions.empty() || conditions.back() != condition) conditions.push_back(condition);
  }
  if (!has_features) return cells;
  for (const std::string& condition : conditions) {
    cells.push_back(feature_difference(runs, condition));
  }
  return cells;
}

}  // namespace

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kUnchanged:
      return "unchanged";
    case Verdict::kBetter:
      return "better";
    case Verdict::kWorse:
      return "worse";
    case Verdict::kMissing:
      return "missing";
  }
  return "";
}

int64_t Comparison::count(Verdict verdict) const {
  return std::count_if(cells.begin(), cells.end(),
                       [&](const CellDifference& cell) { return cell.verdict == verdict; });
}

Comparison compare_runs(const fs::path& base_path, const fs::path& now_path, double tolerance,
                        const std::vector<std::string>& measures) {
  const bool is_base_of_scores = is_of_scores(base_path);
  if (is_base_of_scores != is_of_scores(now_path)) {
    throw InputError(fmt::format("{} holds scores of estimates, {} a run; must be of one kind",
                                 (is_base_of_scores ? base_path : now_path).string(),
                                 (is_base_of_scores ? now_path : base_path).string()));
  }
  if (is_base_of_scores) return compare_scores(base_path, now_path, tolerance, measures);
  const ComparedRun base = read_compared_run(base_path);
  const ComparedRun now = read_compared_run(now_path);
  Comparison comparison;
  comparison.study = base.summary.at("study").get<std::string>();
  comparison.tolerance = tolerance;
  if (now.summary.at("study") != comparison.study) {
    throw InputError(fmt::format("{}: is of the study {}, {} is of {}; must be of one study",
                                 base_path.string(), comparison.study, now_path.string(),
                                 now.summary.at("study").get<std::string>()));
  }
  const std::vector<Measure> chosen = find_measures(measures, base.subject());
  const Pairs pairs = pair_trials(base, now, chosen);
  comparison.how = how_text(pairs);
  comparison.settings = settings_text(base, now);
  try {
    comparison.cells = cell_differences({base, now, pairs, chosen, !measures.empty(), tolerance});
  } catch (const Json::exception& error) {
    throw InputError(fmt::format("{} or {}: a cell of summary.json cannot be read ({})",
                                 base_path.string(), now_path.string(), error.what()));
  }
  if (comparison.cells.empty()) {
    throw InputError(fmt::format("{}: has no trials to compare with", base_path.string()));
  }
  judge(comparison.cells);
  return comparison;
}

}  // namespace sightline
