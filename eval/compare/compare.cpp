// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/compare.h"

#include <algorithm>

#include <fmt/format.h>

#include "eval/compare/pairing.h"
#include "eval/compare/verdicts.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

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

// How the trials of both runs were matched, as a sentence's end.
std::string how_text(const Pairs& pairs) {
  if (!pairs.why_not.empty()) {
    return fmt::format("not paired, but by the intervals of the means, as {}", pairs.why_not);
  }
  const std::string left_out =
      pairs.left_out == 0
          ? ""
          : fmt::format("; {} of the base's are left out of the new run's", pairs.left_out);
  return fmt::format("paired: {} trials that are the same in both{}", pairs.count, left_out);
}

// One cell of the base beside the same of the new run, before its p-values are adjusted.
CellDifference cell_difference(const Json& cell, const Json& now_summary, const Pairs& pairs,
                               double tolerance) {
  CellDifference result;
  result.condition = condition_name(cell.at("condition"));
  result.solver = cell.at("solver").get<std::string>();
  const CellKey key{result.condition, result.solver};
  const Json* const counterpart = find_cell(now_summary, key);
  const auto paired = pairs.cells.find(key);
  const bool is_missing = counterpart == nullptr || !has_trials(*counterpart) ||
                          (pairs.count > 0 && paired == pairs.cells.end());
  if (is_missing) {
    result.verdict = Verdict::kMissing;
    return result;
  }
  result.differences =
      compare_cell(cell, *counterpart, pairs.count > 0 ? &paired->second : nullptr, tolerance,
                   fmt::format("compare/{}/{}/", result.condition, result.solver));
  return result;
}

}  // namespace

int64_t Comparison::count(Verdict verdict) const {
  return std::count_if(cells.begin(), cells.end(),
                       [&](const CellDifference& cell) { return cell.verdict == verdict; });
}

Comparison compare_runs(const fs::path& base_path, const fs::path& now_path, double tolerance) {
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
  const Pairs pairs = pair_trials(base, now);
  comparison.how = how_text(pairs);
  try {
    for (const Json& cell : base.summary.at("cells")) {
      if (!has_trials(cell)) continue;
      comparison.cells.push_back(cell_difference(cell, now.summary, pairs, tolerance));
    }
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
