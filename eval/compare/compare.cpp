// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include <boost/math/distributions/students_t.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "eval/output/text.h"
#include "eval/output/text_table.h"
#include "eval/results/store.h"
#include "eval/summary/summary.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kLevel = 0.05;
// Changes of a mean by less are rounding, whatever their interval.
constexpr double kRounding = 1e-9;

// A mean or a rate that is compared, with its name in summary.json.
struct ErrorQuantity {
  const char* name;
  double EstimateRecord::*of_estimate;
  double OrientationRecord::*of_orientation;
  double cap;
};
constexpr std::array kErrors = {
    ErrorQuantity{"geodesic_deg", &EstimateRecord::geodesic_deg, &OrientationRecord::geodesic_deg,
                  kAngleCapDeg},
    ErrorQuantity{"t_error_percent", &EstimateRecord::t_error_percent,
                  &OrientationRecord::t_error_percent, kTranslationCapPercent},
};

using CellKey = std::pair<std::string, std::string>;  // condition and solver

std::string condition_name(const Json& condition) {
  std::string name;
  for (const auto& [key, value] : condition.items()) {
    const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
    name += fmt::format("{}{} {}", name.empty() ? "" : ", ", key, text);
  }
  return name.empty() ? "all" : name;
}

// One of the two runs.
struct Run {
  fs::path path;
  Json summary;
  std::optional<fs::path> store;
  std::vector<std::string> conditions;  // by index
};

Run read_run(const fs::path& path) {
  Run run;
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

// A number of a summary; NaN for null.
double number_in(const Json& json) {
  return json.is_number() ? json.get<double>() : kNoNumber;
}

// ---- Trial by trial ----

// The differences of one cell, new minus base.
struct PairedCell {
  std::array<std::vector<double>, kErrors.size()> base;
  std::array<std::vector<double>, kErrors.size()> differences;
  std::vector<double> failures;  // -1, 0 or 1
  int64_t base_failures = 0;
  int64_t now_failures = 0;
};

// What a solver or method made of a trial.
struct TrialErrors {
  std::string_view solver;
  bool is_failed = false;
  std::array<double, kErrors.size()> errors{};  // capped
};

std::vector<TrialErrors> errors_of(const TrialRecord& trial) {
  std::vector<TrialErrors> all;
  const auto capped = [](double error, double cap) { return error < cap ? error : cap; };
  for (const EstimateRecord& estimate : trial.estimates()) {
    TrialErrors& of_solver = all.emplace_back();
    of_solver.solver = estimate.solver;
    of_solver.is_failed = !estimate.is_ok();
    for (size_t i = 0; i < kErrors.size(); ++i) {
      const double error = estimate.*kErrors[i].of_estimate;
      of_solver.errors[i] = of_solver.is_failed ? kErrors[i].cap : capped(error, kErrors[i].cap);
    }
  }
  for (const OrientationRecord& orientation : trial.orientations()) {
    TrialErrors& of_method = all.emplace_back();
    of_method.solver = orientation.method;
    of_method.is_failed = orientation.failures > 0;
    for (size_t i = 0; i < kErrors.size(); ++i) {
      of_method.errors[i] = capped(orientation.*kErrors[i].of_orientation, kErrors[i].cap);
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
    for (size_t i = 0; i < kErrors.size(); ++i) {
      cell.base[i].push_back(before.errors[i]);
      cell.differences[i].push_back(after->errors[i] - before.errors[i]);
    }
    cell.failures.push_back(int{after->is_failed} - int{before.is_failed});
    cell.base_failures += before.is_failed;
    cell.now_failures += after->is_failed;
  }
}

struct Pairs {
  std::map<CellKey, PairedCell> cells;
  int64_t count = 0;
  int64_t left_out = 0;  // of the base's up to the new run's last: a whole run has them all
  std::string why_not;   // in words, where there are none
};

std::string condition_of(const Run& run, const TrialRecord& trial) {
  const auto index = static_cast<size_t>(trial.condition);
  return index < run.conditions.size() ? run.conditions[index] : "";
}

Pairs pair_trials(const Run& base, const Run& now) {
  Pairs pairs;
  for (const Run* run : {&base, &now}) {
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

// ---- Numbers ----

// p-values of one side each: now above base, and below.
struct Sides {
  double worse = 1;
  double better = 1;
};

// The verdict stands if the p-value, adjusted, is small enough.
void set_sides(Difference& difference, const Sides& sides, double allowed) {
  difference.p = std::min(1.0, 2 * std::min(sides.worse, sides.better));
  if (difference.ci95[0] > allowed) difference.verdict = Verdict::kWorse;
  if (difference.ci95[1] < -allowed) difference.verdict = Verdict::kBetter;
}

void set_p(Difference& difference, double two_sided, double tolerance) {
  const double change = difference.now - difference.base;
  if (std::abs(change) <= tolerance) return;
  difference.p = two_sided;
  difference.verdict = change > 0 ? Verdict::kWorse : Verdict::kBetter;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

std::vector<double> affine(const std::vector<double>& values, double factor, double offset) {
  std::vector<double> result;
  for (const double value : values) result.push_back(factor * value + offset);
  return result;
}

Difference paired_error(const PairedCell& cell, size_t quantity, double tolerance,
                        const std::string& stream) {
  const std::vector<double>& differences = cell.differences[quantity];
  Difference result;
  result.quantity = kErrors[quantity].name;
  result.trials = static_cast<int64_t>(differences.size());
  result.base = mean_of(cell.base[quantity]);
  result.now = result.base + mean_of(differences);
  result.ci95 = bca_mean_interval(differences, 1, stream);
  const double allowed = std::max(tolerance, kRounding) * result.base;
  set_sides(result,
            {p_mean_above_zero(affine(differences, 1, -allowed)),
             p_mean_above_zero(affine(differences, -1, -allowed))},
            allowed);
  return result;
}

Difference paired_failures(const PairedCell& cell, double tolerance, const std::string& stream) {
  Difference result;
  result.quantity = "failures";
  result.trials = static_cast<int64_t>(cell.failures.size());
  const double n = static_cast<double>(result.trials);
  result.base = static_cast<double>(cell.base_failures) / n;
  result.now = static_cast<double>(cell.now_failures) / n;
  result.ci95 = bca_mean_interval(cell.failures, 1, stream);
  const int64_t only_now = std::count(cell.failures.begin(), cell.failures.end(), 1);
  const int64_t only_base = std::count(cell.failures.begin(), cell.failures.end(), -1);
  set_p(result, mcnemar_p(only_base, only_now), tolerance);
  return result;
}

Difference stored_error(const Json& base, const Json& now, const char* name, double tolerance) {
  Difference result;
  result.quantity = name;
  result.trials = now.at("trials").get<int64_t>();
  result.base = number_in(base.at(name).at("mean"));
  result.now = number_in(now.at(name).at("mean"));
  const auto interval = [name](const Json& cell) {
    const Json& ends = cell.at(name).at("mean_ci95");
    return Interval95{number_in(ends.at(0)), number_in(ends.at(1))};
  };
  result.ci95 = difference_interval(result.base, interval(base), result.now, interval(now));
  const int64_t fewer = std::min(base.at("trials").get<int64_t>(), result.trials);
  const double change = result.now - result.base;
  const double allowed = std::max(tolerance, kRounding) * result.base;
  if (fewer < 2 || !std::isfinite(result.ci95[0]) || !std::isfinite(result.ci95[1])) return result;
  const boost::math::students_t t(static_cast<double>(fewer - 1));
  // The interval's half-width on the side of zero stands for its standard error.
  const auto p_beyond = [&](double excess, double half_width) {
    if (half_width <= 0) return excess > 0 ? 0.0 : 1.0;
    return boost::math::cdf(t, -excess / (half_width / normal_quantile(0.975)));
  };
  set_sides(result,
            {p_beyond(change - allowed, change - result.ci95[0]),
             p_beyond(-change - allowed, result.ci95[1] - change)},
            allowed);
  return result;
}

Difference stored_failures(const Json& base, const Json& now, double tolerance) {
  Difference result;
  result.quantity = "failures";
  const int64_t trials_base = base.at("trials").get<int64_t>();
  const int64_t trials_now = now.at("trials").get<int64_t>();
  const int64_t failures_base = base.at("failures").get<int64_t>();
  const int64_t failures_now = now.at("failures").get<int64_t>();
  result.trials = trials_now;
  result.base = static_cast<double>(failures_base) / static_cast<double>(trials_base);
  result.now = static_cast<double>(failures_now) / static_cast<double>(trials_now);
  result.ci95 = difference_interval(result.base, wilson_interval(failures_base, trials_base),
                                    result.now, wilson_interval(failures_now, trials_now));
  set_p(result, fisher_p(failures_base, trials_base, failures_now, trials_now), tolerance);
  return result;
}

// ---- Cells ----

std::vector<Difference> compare_cell(const Json& base, const Json& now, const PairedCell* pairs,
                                     double tolerance, const std::string& stream) {
  std::vector<Difference> differences;
  for (size_t i = 0; i < kErrors.size(); ++i) {
    differences.push_back(pairs != nullptr
                              ? paired_error(*pairs, i, tolerance, stream + kErrors[i].name)
                              : stored_error(base, now, kErrors[i].name, tolerance));
  }
  differences.push_back(pairs != nullptr ? paired_failures(*pairs, tolerance, stream + "failures")
                                         : stored_failures(base, now, tolerance));
  return differences;
}

// Adjusts the p-values over all cells, and says what they mean.
void judge(std::vector<CellDifference>& cells) {
  std::vector<double> p_values;
  for (const CellDifference& cell : cells) {
    for (const Difference& difference : cell.differences) p_values.push_back(difference.p);
  }
  const std::vector<double> adjusted = holm_adjusted(p_values);
  size_t next = 0;
  for (CellDifference& cell : cells) {
    for (Difference& difference : cell.differences) {
      difference.p = adjusted[next++];
      if (difference.p >= kLevel) difference.verdict = Verdict::kUnchanged;
      if (difference.verdict == Verdict::kWorse) cell.verdict = Verdict::kWorse;
      if (difference.verdict == Verdict::kBetter && cell.verdict == Verdict::kUnchanged) {
        cell.verdict = Verdict::kBetter;
      }
    }
  }
}

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

}  // namespace

int64_t Comparison::count(Verdict verdict) const {
  return std::count_if(cells.begin(), cells.end(),
                       [&](const CellDifference& cell) { return cell.verdict == verdict; });
}

Comparison compare_runs(const fs::path& base_path, const fs::path& now_path, double tolerance) {
  const Run base = read_run(base_path);
  const Run now = read_run(now_path);
  Comparison comparison;
  comparison.study = base.summary.at("study").get<std::string>();
  comparison.tolerance = tolerance;
  if (now.summary.at("study") != comparison.study) {
    throw InputError(fmt::format("{}: is of the study {}, {} is of {}; must be of one study",
                                 base_path.string(), comparison.study, now_path.string(),
                                 now.summary.at("study").get<std::string>()));
  }
  const Pairs pairs = pair_trials(base, now);
  const std::string left_out =
      pairs.left_out == 0
          ? ""
          : fmt::format("; {} of the base's are left out of the new run's", pairs.left_out);
  comparison.how =
      pairs.why_not.empty()
          ? fmt::format("paired: {} trials that are the same in both{}", pairs.count, left_out)
          : fmt::format("not paired, but by the intervals of the means, as {}", pairs.why_not);
  try {
    for (const Json& cell : base.summary.at("cells")) {
      if (!has_trials(cell)) continue;
      CellDifference& result = comparison.cells.emplace_back();
      result.condition = condition_name(cell.at("condition"));
      result.solver = cell.at("solver").get<std::string>();
      const CellKey key{result.condition, result.solver};
      const Json* const counterpart = find_cell(now.summary, key);
      const auto paired = pairs.cells.find(key);
      const bool is_missing = counterpart == nullptr || !has_trials(*counterpart) ||
                              (pairs.count > 0 && paired == pairs.cells.end());
      if (is_missing) {
        result.verdict = Verdict::kMissing;
        continue;
      }
      result.differences =
          compare_cell(cell, *counterpart, pairs.count > 0 ? &paired->second : nullptr, tolerance,
                       fmt::format("compare/{}/{}/", result.condition, result.solver));
    }
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("{} or {}: a cell of summary.json cannot be read ({})",
                                 base_path.string(), now_path.string(), error.what()));
  }
  if (comparison.cells.empty()) {
    throw InputError(fmt::format("{}: has no trials to compare with", base_path.string()));
  }
  judge(comparison.cells);
  return comparison;
}

namespace {

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

std::string short_number(double value) {
  return std::isfinite(value) ? fmt::format("{:.3g}", value) : "-";
}

std::string change_text(const Difference& d) {
  if (!(d.base > 0)) return short_number(d.now - d.base);
  return fmt::format("{:+.1f} %", 100 * (d.now - d.base) / d.base);
}

std::string interval_text(const Interval95& ends) {
  return fmt::format("[{}, {}]", short_number(ends[0]), short_number(ends[1]));
}

std::string p_text(double p) {
  return p < 1e-4 ? "< 0.0001" : fmt::format("{:.4f}", p);
}

std::string counts_text(const Comparison& comparison) {
  std::string text =
      fmt::format("{} cell{}: {} worse, {} better, {} unchanged", comparison.cells.size(),
                  comparison.cells.size() == 1 ? "" : "s", comparison.count(Verdict::kWorse),
                  comparison.count(Verdict::kBetter), comparison.count(Verdict::kUnchanged));
  const int64_t missing = comparison.count(Verdict::kMissing);
  return missing > 0 ? fmt::format("{}, {} missing", text, missing) : text;
}

std::string rule_text(const Comparison& comparison) {
  return fmt::format(
      "Worse or better: the interval of the change lies beyond the tolerance of {:g} %, and p < {} "
      "adjusted by Holm over all numbers compared.",
      100 * comparison.tolerance, kLevel);
}

// The changes of a cell in one line; empty where nothing has changed.
std::string changes_text(const CellDifference& cell) {
  if (cell.verdict == Verdict::kMissing) return "the new run lacks this cell";
  std::string text;
  for (const Difference& d : cell.differences) {
    if (d.verdict == Verdict::kUnchanged) continue;
    text += fmt::format("{}{} is {}: {} to {} ({}), difference {}, p {}", text.empty() ? "" : "; ",
                        d.quantity, to_string(d.verdict), short_number(d.base), short_number(d.now),
                        change_text(d), interval_text(d.ci95), p_text(d.p));
  }
  return text;
}

}  // namespace

std::string to_text(const Comparison& comparison) {
  constexpr size_t kMostRows = 30;
  constexpr size_t kLongestLabel = 40;
  std::vector<std::string> labels;
  TextColumn verdicts{"verdict", {}}, bases{"base", {}}, news{"new", {}}, changes{"change", {}},
      intervals{"95 % of new - base", {}}, p_values{"p", {}};
  size_t left_out = 0;
  for (const CellDifference& cell : comparison.cells) {
    const std::string name = fmt::format("{}, {}", cell.condition, cell.solver);
    std::vector<Difference> differences = cell.differences;
    if (cell.verdict == Verdict::kMissing) differences.emplace_back().verdict = cell.verdict;
    for (const Difference& d : differences) {
      if (d.verdict == Verdict::kUnchanged) continue;
      if (labels.size() == kMostRows) {
        ++left_out;
        continue;
      }
      labels.push_back(shortened(fmt::format("{} {}", name, d.quantity), kLongestLabel));
      verdicts.cells.emplace_back(to_string(d.verdict));
      bases.cells.push_back(short_number(d.base));
      news.cells.push_back(short_number(d.now));
      changes.cells.push_back(std::isfinite(d.base) ? change_text(d) : "-");
      intervals.cells.push_back(interval_text(d.ci95));
      p_values.cells.push_back(p_text(d.p));
    }
  }
  std::string text = wrapped(fmt::format("{}, {}", comparison.study, comparison.how)) +
                     wrapped(counts_text(comparison));
  if (labels.empty()) return text;
  text += text_block("What changed", labels,
                     {{"", {verdicts, bases, news, changes, intervals, p_values}}});
  if (left_out > 0) text += fmt::format("and {} more, which --markdown FILE lists\n", left_out);
  return text + "\n" + wrapped(rule_text(comparison));
}

std::string to_markdown(const Comparison& comparison) {
  std::string text = fmt::format("## {}: {}\n\n{}; {}. {}\n\n", comparison.study,
                                 comparison.has_regression() ? "worse" : "no regression",
                                 counts_text(comparison), comparison.how, rule_text(comparison));
  text +=
      "| condition | solver | number | verdict | base | new | change | 95 % of new - base | p |\n";
  text += "|---|---|---|---|--:|--:|--:|--:|--:|\n";
  for (const CellDifference& cell : comparison.cells) {
    if (cell.verdict == Verdict::kMissing) {
      text += fmt::format("| {} | {} | | **missing** | | | | | |\n", cell.condition, cell.solver);
    }
    for (const Difference& d : cell.differences) {
      const std::string verdict(to_string(d.verdict));
      text += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", cell.condition,
                          cell.solver, d.quantity,
                          d.verdict == Verdict::kUnchanged ? verdict : "**" + verdict + "**",
                          short_number(d.base), short_number(d.now), change_text(d),
                          interval_text(d.ci95), p_text(d.p));
    }
  }
  return text;
}

std::string to_junit(const Comparison& comparison) {
  const int64_t failures = comparison.count(Verdict::kWorse) + comparison.count(Verdict::kMissing);
  const std::string totals =
      fmt::format("tests=\"{}\" failures=\"{}\"", comparison.cells.size(), failures);
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  text += fmt::format("<testsuites {0}>\n<testsuite name=\"{1}\" {0}>\n", totals,
                      escape_html(comparison.study));
  for (const CellDifference& cell : comparison.cells) {
    text += fmt::format("<testcase classname=\"{}.{}\" name=\"{}\"", escape_html(comparison.study),
                        escape_html(cell.condition), escape_html(cell.solver));
    const std::string changes = escape_html(changes_text(cell));
    const bool is_failure = cell.verdict == Verdict::kWorse || cell.verdict == Verdict::kMissing;
    if (is_failure) {
      text += fmt::format("><failure message=\"{}\"/></testcase>\n", changes);
    } else if (!changes.empty()) {
      text += fmt::format("><system-out>{}</system-out></testcase>\n", changes);
    } else {
      text += "/>\n";
    }
  }
  return text + "</testsuite>\n</testsuites>\n";
}

}  // namespace sightline
