// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The pose errors of the ORPE paper's Table 1: by condition and solver our means with their
// intervals, and beside them what the paper prints, or our medians where it prints nothing.
#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <kainjow/mustache.hpp>

#include "eval/output/numbers.h"
#include "eval/output/words.h"
#include "eval/report/figures.h"
#include "eval/report/means.h"
#include "eval/report/page_text.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

constexpr size_t kMostLostNamed = 20;  // of a condition

bool has_given_poses(const Study& study) {
  return !study.pose_law()->theta_deg.empty();
}

std::string caption(const Study& study) {
  const std::string what =
      "Mean errors of the pose, with 95 % bootstrap intervals of the mean in brackets";
  if (has_paper_figures(study)) {
    return fmt::format(
        "{}, beside the figures that the paper prints ({}).", what,
        study.reference.empty() ? "as the study’s file quotes them" : study.reference);
  }
  return what + ", and the medians.";
}

std::string note(const Study& study) {
  std::string text =
      "Bound: the Cramér–Rao bound of the pose from the true inliers, each feature with the noise "
      "that it shows in that row; mean over the trials. A solver that keeps outliers uses points "
      "that the bound leaves out.";
  if (has_paper_figures(study)) {
    text += " The paper prints one trial a pose, without an interval.";
  }
  return text;
}

mustache::object cell(double theta_mean, const std::array<double, 2>& theta_ci95, double t_mean,
                      const std::array<double, 2>& t_ci95) {
  return {{"theta_mean", measure(theta_mean)},
          {"theta_interval", interval(theta_ci95, decimals_for(theta_mean))},
          {"t_mean", measure(t_mean)},
          {"t_interval", interval(t_ci95, decimals_for(t_mean))}};
}

void set_failures(mustache::object& cell, int failures) {
  cell["has_failures"] = failures > 0;
  cell["failures"] = fmt::to_string(failures);
}

void set_paper(mustache::object& cell, const PaperFigure* figure) {
  cell["theta_beside"] = figure == nullptr ? "–" : fixed(figure->theta_error_deg, 2);
  cell["t_beside"] = figure == nullptr ? "–" : fixed(figure->t_error_percent, 1);
}

mustache::object condition_row(const ReportInput& input, int condition, std::string_view solver) {
  const CellSummary* found = find_cell(input.summary, condition, solver);
  const CellSummary summary = found == nullptr ? CellSummary{} : *found;
  const ErrorSummary& theta = summary.theta_error_deg;
  const ErrorSummary& t = summary.t_error_percent;
  mustache::object row = cell(theta.mean, theta.mean_ci95, t.mean, t.mean_ci95);
  set_failures(row, summary.failures);
  if (has_paper_figures(input.study)) {
    set_paper(row, paper_figure(input.study.conditions[condition], solver));
  } else {
    row["theta_beside"] = measure(theta.median);
    row["t_beside"] = measure(t.median);
  }
  return row;
}

mustache::object mean_row(const ReportInput& input, std::string_view solver) {
  const SolverMeans means = means_over_conditions(input.study, input.summary, solver);
  mustache::object row = cell(means.theta_error_deg.value, means.theta_error_deg.ci95,
                              means.t_error_percent.value, means.t_error_percent.ci95);
  set_failures(row, means.failures);
  set_paper(row, means.paper ? &*means.paper : nullptr);
  return row;
}

template <typename RowOf>
mustache::data rows(const Study& study, const RowOf& row_of) {
  mustache::data list(mustache::data::type::list);
  for (const TrialSolver& solver : study.solvers()) {
    mustache::object row = row_of(solver.name);
    row["solver"] = solver_label(solver.name);
    list << mustache::data(row);
  }
  return list;
}

void set_observations(mustache::object& group, const CellObservations& observations) {
  group["bound_theta"] = measure(observations.bound_theta_deg);
  group["bound_t"] = measure(observations.bound_t_percent);
  group["inlier_rms"] = measure(observations.inlier_rms_px);
  group["outliers"] = measure(observations.outliers);
}

mustache::data condition_group(const ReportInput& input, int condition) {
  const Study& study = input.study;
  const Condition& cell = study.conditions[condition];
  mustache::object group = {
      {"label", cell.label}, {"is_mean", false}, {"has_pose", has_given_poses(study)}};
  if (has_given_poses(study)) {
    const ImageStudy& images = *study.images();
    const int pose = images.cells[condition].pose;
    group["theta"] = triple(images.pose_law().theta_deg[pose], 0);
    group["t"] = triple(images.pose_law().t_m[pose], 0);
  }
  group["rows"] =
      rows(study, [&](std::string_view solver) { return condition_row(input, condition, solver); });
  const CellObservations* found = find_observations(input.summary, condition);
  set_observations(group, found == nullptr ? CellObservations{} : *found);
  return group;
}

CellObservations mean_observations(const Summary& summary) {
  CellObservations mean;
  for (double CellObservations::*member :
       {&CellObservations::outliers, &CellObservations::inlier_rms_px,
        &CellObservations::bound_theta_deg, &CellObservations::bound_t_percent}) {
    mean.*member = mean_over_conditions(summary, member);
  }
  return mean;
}

mustache::data mean_group(const ReportInput& input) {
  mustache::object group = {{"label", "mean"}, {"is_mean", true}, {"has_pose", false}};
  group["rows"] =
      rows(input.study, [&](std::string_view solver) { return mean_row(input, solver); });
  set_observations(group, mean_observations(input.summary));
  return group;
}

mustache::data groups(const ReportInput& input) {
  mustache::data list(mustache::data::type::list);
  const int conditions = static_cast<int>(input.study.conditions.size());
  for (int condition = 0; condition < conditions; ++condition) {
    list << condition_group(input, condition);
  }
  // A mean over other conditions than poses (noise, say) would say nothing.
  if (conditions > 1 && has_given_poses(input.study)) list << mean_group(input);
  return list;
}

mustache::data detail(const CellSummary& cell) {
  const int capped = std::max(cell.theta_error_deg.capped, cell.t_error_percent.capped);
  return mustache::object{
      {"solver", solver_label(cell.solver)},
      {"trials", fmt::to_string(cell.trials)},
      {"failed", fmt::to_string(cell.failures)},
      {"capped", fmt::to_string(capped)},
      {"false_removals", measure(cell.false_removals)},
      {"missed", measure(cell.missed_outliers)},
      {"exact", fixed(100 * cell.exact_set_rate, 1)},
      {"theta_median", measure(cell.theta_error_deg.median)},
      {"t_median", measure(cell.t_error_percent.median)},
      {"oracle_ratio", measure(cell.ratio_to_oracle)},
      {"bound_ratio", measure(cell.ratio_to_bound)},
  };
}

mustache::data detail_groups(const ReportInput& input) {
  mustache::data list(mustache::data::type::list);
  for (size_t i = 0; i < input.study.conditions.size(); ++i) {
    mustache::data details(mustache::data::type::list);
    for (const CellSummary& cell : input.summary.cells) {
      if (cell.condition == static_cast<int>(i)) details << detail(cell);
    }
    list << mustache::object{{"condition", input.study.conditions[i].label}, {"details", details}};
  }
  return list;
}

// Trials without a picture, by condition.
std::vector<std::vector<int64_t>> lost_trials(const ReportInput& input) {
  std::vector<std::vector<int64_t>> lost(input.study.conditions.size());
  for (const TrialRecord& trial : input.trials) {
    if (trial.observations().empty()) lost[trial.condition].push_back(trial.trial);
  }
  return lost;
}

mustache::data lost_lines(const Study& study, const std::vector<std::vector<int64_t>>& lost) {
  mustache::data list(mustache::data::type::list);
  for (size_t i = 0; i < lost.size(); ++i) {
    if (lost[i].empty()) continue;
    const size_t named = std::min(lost[i].size(), kMostLostNamed);
    std::string text = fmt::format("{}", fmt::join(lost[i].begin(), lost[i].begin() + named, ", "));
    if (named < lost[i].size()) text += fmt::format(" and {} more", lost[i].size() - named);
    list << mustache::object{{"condition", study.conditions[i].label}, {"trials", text}};
  }
  return list;
}

std::string failures(const Summary& summary) {
  int64_t failed = 0;
  int64_t estimates = 0;
  for (const CellSummary& cell : summary.cells) {
    failed += cell.failures;
    estimates += cell.trials;
  }
  if (failed == 0) return fmt::format("none of {} failed", counted(estimates, "estimate"));
  return fmt::format("{} of {} failed", failed, counted(estimates, "estimate"));
}

}  // namespace

std::string table_figure(const ReportInput& input) {
  if (input.study.images() == nullptr) return "";  // it has the sweep's tables
  const auto lost = lost_trials(input);
  size_t lost_count = 0;
  for (const std::vector<int64_t>& of_condition : lost) lost_count += of_condition.size();
  return mustache::mustache(page_text("table.mustache"))
      .render(mustache::object{
          {"caption", caption(input.study)},
          {"note", note(input.study)},
          {"beside", has_paper_figures(input.study) ? "paper" : "median"},
          {"groups", groups(input)},
          {"has_lost", lost_count > 0},
          {"lost_how", !input.study.renders() ? "run" : "imaged"},
          {"lost_count", fmt::format("{} of {}", lost_count,
                                     counted(static_cast<int64_t>(input.trials.size()), "trial"))},
          {"lost", lost_lines(input.study, lost)},
          {"failures", failures(input.summary)},
          {"detail_groups", detail_groups(input)},
      });
}

}  // namespace sightline
