// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The pose errors in the shape of the ORPE paper's Table 1: a row a condition, our means with their
// intervals, and beside them what the paper prints, or our medians where it prints nothing.
#include <algorithm>

#include <fmt/format.h>
#include <kainjow/mustache.hpp>

#include "eval/report/figures.h"
#include "eval/report/means.h"
#include "eval/report/text.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

constexpr const char* kTemplate = R"html(
<div class="scroll" role="region" aria-label="Pose errors, table" tabindex="0">
<table class="poses">
<caption><span>{{caption}}</span></caption>
<thead>
<tr>
{{#given_poses}}<th scope="colgroup" colspan="2">True pose</th>{{/given_poses}}
{{^given_poses}}<th scope="col" rowspan="2">Condition</th>{{/given_poses}}
{{#solvers}}<th scope="colgroup" colspan="{{columns}}" class="group">{{label}}</th>{{/solvers}}
<th scope="colgroup" colspan="2" class="group">Bound</th>
<th scope="colgroup" colspan="2" class="group">Features</th>
</tr>
<tr>
{{#given_poses}}<th scope="col"><span class="hidden">Name</span></th>
<th scope="col" class="text"><i>θ</i>, °<br><i>T</i>, m</th>{{/given_poses}}
{{#solvers}}
<th scope="col" class="group"><i>θ</i> error, °</th>{{#beside}}<th scope="col"
class="beside">{{beside_label}}</th>{{/beside}}
<th scope="col"><i>T</i> error, %</th>{{#beside}}<th scope="col"
class="beside">{{beside_label}}</th>{{/beside}}
{{/solvers}}
<th scope="col" class="group"><i>θ</i>, °</th><th scope="col"><i>T</i>, %</th>
<th scope="col" class="group">inlier RMS, px</th><th scope="col">outliers a trial</th>
</tr>
</thead>
<tbody>
{{#rows}}
<tr{{#is_mean}} class="mean"{{/is_mean}}>
<th scope="row">{{label}}</th>
{{#given_poses}}<td class="pose">{{theta}}<br>{{t}}</td>{{/given_poses}}
{{#cells}}
<td class="group"><b>{{theta_mean}}</b> <span
class="interval">{{theta_interval}}</span>{{#has_failures}}<span
class="failed">{{failures}} failed</span>{{/has_failures}}</td>
{{#beside}}<td class="beside">{{theta_beside}}</td>{{/beside}}
<td><b>{{t_mean}}</b> <span class="interval">{{t_interval}}</span></td>
{{#beside}}<td class="beside">{{t_beside}}</td>{{/beside}}
{{/cells}}
<td class="group">{{bound_theta}}</td><td>{{bound_t}}</td>
<td class="group">{{inlier_rms}}</td><td>{{outliers}}</td>
</tr>
{{/rows}}
</tbody>
</table>
</div>
<p class="note">{{note}}</p>
<details>
<summary>Failures and removed features: {{failures}}</summary>
<div class="scroll" role="region" aria-label="Failures and removed features, table" tabindex="0">
<table>
<caption><span>What failed and what was removed, by condition and solver. A failed trial counts as
the cap in
every mean and as infinite in every median.</span></caption>
<thead><tr><th scope="col">Condition</th><th scope="col">Solver</th><th scope="col">trials</th>
<th scope="col">failed</th><th scope="col">at the cap</th><th scope="col">inliers removed a
trial</th>
<th scope="col">outliers kept a trial</th><th scope="col">exactly right set, %</th>
<th scope="col">median <i>θ</i> error, °</th><th scope="col">median <i>T</i> error, %</th>
<th scope="col">RMS over oracle’s</th><th scope="col">RMS over bound</th></tr></thead>
<tbody>
{{#details}}
<tr><th scope="row">{{condition}}</th><td
class="text">{{solver}}</td><td>{{trials}}</td><td>{{failed}}</td>
<td>{{capped}}</td><td>{{false_removals}}</td><td>{{missed}}</td><td>{{exact}}</td>
<td>{{theta_median}}</td>
<td>{{t_median}}</td><td>{{oracle_ratio}}</td><td>{{bound_ratio}}</td></tr>
{{/details}}
</tbody>
</table>
</div>
<p class="note">The two ratios compare RMS geodesic errors (capped), over the same trials.</p>
</details>
)html";

// What stands beside a solver's mean.
enum class Beside { kNothing, kPaper, kMedian };

bool has_given_poses(const Study& study) {
  return !study.poses.theta_deg.empty();
}

Beside beside(const Study& study, std::string_view solver) {
  if (!has_paper_figures(study)) return Beside::kMedian;
  for (const Condition& condition : study.conditions) {
    if (paper_figure(condition, solver) != nullptr) return Beside::kPaper;
  }
  return Beside::kNothing;
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

mustache::object condition_cell(const ReportInput& input, int condition, std::string_view solver) {
  const CellSummary* found = find_cell(input.summary, condition, solver);
  const CellSummary summary = found == nullptr ? CellSummary{} : *found;
  const ErrorSummary& theta = summary.theta_error_deg;
  const ErrorSummary& t = summary.t_error_percent;
  mustache::object object = cell(theta.mean, theta.mean_ci95, t.mean, t.mean_ci95);
  set_failures(object, summary.failures);
  const Beside kind = beside(input.study, solver);
  object["beside"] = kind != Beside::kNothing;
  if (kind == Beside::kMedian) {
    object["theta_beside"] = measure(theta.median);
    object["t_beside"] = measure(t.median);
  } else {
    set_paper(object, paper_figure(input.study.conditions[condition], solver));
  }
  return object;
}

mustache::object mean_cell(const ReportInput& input, std::string_view solver) {
  const SolverMeans means = means_over_conditions(input.study, input.summary, solver);
  mustache::object object = cell(means.theta_error_deg.mean, means.theta_error_deg.ci95,
                                 means.t_error_percent.mean, means.t_error_percent.ci95);
  set_failures(object, means.failures);
  object["beside"] = beside(input.study, solver) != Beside::kNothing;
  set_paper(object, means.paper ? &*means.paper : nullptr);
  return object;
}

template <typename CellOf>
mustache::data cells(const Study& study, const CellOf& cell_of) {
  mustache::data list(mustache::data::type::list);
  for (const PoseSolver* solver : study.solvers) list << cell_of(solver->name);
  return list;
}

void set_observations(mustache::object& row, const CellObservations& observations) {
  row["bound_theta"] = measure(observations.bound_theta_deg);
  row["bound_t"] = measure(observations.bound_t_percent);
  row["inlier_rms"] = measure(observations.inlier_rms_px);
  row["outliers"] = measure(observations.outliers);
}

mustache::data condition_row(const ReportInput& input, int condition) {
  const Study& study = input.study;
  mustache::object row = {{"label", study.conditions[condition].label}, {"is_mean", false}};
  if (has_given_poses(study)) {
    row["theta"] = triple(study.poses.theta_deg[study.conditions[condition].pose], 0);
    row["t"] = triple(study.poses.t_m[study.conditions[condition].pose], 0);
  }
  row["cells"] = cells(
      study, [&](std::string_view solver) { return condition_cell(input, condition, solver); });
  const CellObservations* found = find_observations(input.summary, condition);
  set_observations(row, found == nullptr ? CellObservations{} : *found);
  return row;
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

mustache::data mean_row(const ReportInput& input) {
  mustache::object row = {{"label", "mean"}, {"is_mean", true}, {"theta", ""}, {"t", ""}};
  row["cells"] =
      cells(input.study, [&](std::string_view solver) { return mean_cell(input, solver); });
  set_observations(row, mean_observations(input.summary));
  return row;
}

mustache::data rows(const ReportInput& input) {
  mustache::data list(mustache::data::type::list);
  const int conditions = static_cast<int>(input.study.conditions.size());
  for (int condition = 0; condition < conditions; ++condition) {
    list << condition_row(input, condition);
  }
  // A mean over other conditions than poses (noise, say) would say nothing.
  if (conditions > 1 && has_given_poses(input.study)) list << mean_row(input);
  return list;
}

mustache::data solver_heads(const Study& study) {
  mustache::data list(mustache::data::type::list);
  for (const PoseSolver* solver : study.solvers) {
    const Beside kind = beside(study, solver->name);
    list << mustache::object{{"label", solver_label(solver->name)},
                             {"columns", kind == Beside::kNothing ? "2" : "4"},
                             {"beside", kind != Beside::kNothing},
                             {"beside_label", kind == Beside::kPaper ? "paper" : "median"}};
  }
  return list;
}

mustache::data detail(const Study& study, const CellSummary& cell) {
  const int capped = std::max(cell.theta_error_deg.capped, cell.t_error_percent.capped);
  return mustache::object{
      {"condition", study.conditions[cell.condition].label},
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

mustache::data details(const ReportInput& input) {
  mustache::data list(mustache::data::type::list);
  for (const CellSummary& cell : input.summary.cells) list << detail(input.study, cell);
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
  if (input.study.kind != StudyKind::kImages) return "";  // it has the sweep's tables
  return mustache::mustache(kTemplate).render(mustache::object{
      {"caption", caption(input.study)},
      {"note", note(input.study)},
      {"given_poses", has_given_poses(input.study)},
      {"solvers", solver_heads(input.study)},
      {"rows", rows(input)},
      {"failures", failures(input.summary)},
      {"details", details(input)},
  });
}

}  // namespace sightline
