// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Errors against what is swept, a chart a quantity; of a study without images a table of all
// numbers too, and the answer in short: each solver's worst condition.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <kainjow/mustache.hpp>

#include "eval/output/numbers.h"
#include "eval/report/figures.h"
#include "eval/report/page_text.h"
#include "eval/report/panels.h"
#include "eval/summary/cells.h"
#include "eval/summary/claims.h"
#include "eval/tables/sweep_table.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

int condition_count(const Study& study) {
  return static_cast<int>(study.conditions.size());
}

bool is_orientation(const Study& study) {
  return study.orientation() != nullptr;
}

bool is_timed(const Study& study) {
  return study.takes_times();
}

using Quantities = std::vector<SweepQuantity>;

Quantities quantities_of(const ReportInput& input, bool are_details) {
  Quantities some = sweep_quantities(input.study, input.summary);
  std::erase_if(some, [&](const SweepQuantity& q) { return q.is_detail != are_details; });
  return some;
}

// A heading of the terminal's tables, for readers: "theta_error" is the θ error.
std::string spelt(const std::string& heading) {
  constexpr std::string_view kTheta = "theta_error";
  if (heading.starts_with(kTheta)) return "θ error" + heading.substr(kTheta.size());
  constexpr std::string_view kT = "T_error";
  if (heading.starts_with(kT)) return "T error" + heading.substr(kT.size());
  return heading;
}

bool has_bound(const SweepQuantity& quantity) {
  return quantity.bound != nullptr;
}

mustache::data solver_row(const ReportInput& input, const Quantities& quantities, int condition,
                          const std::string& solver) {
  mustache::data cells(mustache::data::type::list);
  const CellSummary& cell = cell_at(input.summary, condition, solver);
  for (const SweepQuantity& quantity : quantities) {
    const int decimals = sweep_decimals(input.summary, quantity);
    const bool has_interval = quantity.interval != nullptr;
    cells << mustache::object{
        {"value", fixed(quantity.value(cell), decimals)},
        {"has_interval", has_interval},
        {"interval", has_interval ? interval(quantity.interval(cell), decimals) : ""}};
  }
  return mustache::object{{"label", label_in(input.study, solver)}, {"cells", cells}};
}

mustache::data bound_row(const ReportInput& input, const Quantities& quantities, int condition) {
  const CellObservations* found = find_observations(input.summary, condition);
  mustache::data cells(mustache::data::type::list);
  for (const SweepQuantity& quantity : quantities) {
    const bool is_there = has_bound(quantity) && found != nullptr;
    const int decimals = sweep_decimals(input.summary, quantity);
    cells << mustache::object{{"value", is_there ? fixed(found->*quantity.bound, decimals) : ""},
                              {"has_interval", false}};
  }
  return mustache::object{{"label", "bound"}, {"cells", cells}};
}

mustache::data condition_group(const ReportInput& input, const Quantities& quantities,
                               int condition) {
  mustache::data rows(mustache::data::type::list);
  for (const std::string& solver : input.study.solver_names()) {
    rows << solver_row(input, quantities, condition, solver);
  }
  if (std::any_of(quantities.begin(), quantities.end(), has_bound)) {
    rows << bound_row(input, quantities, condition);
  }
  return mustache::object{{"label", input.study.conditions[condition].label}, {"rows", rows}};
}

std::string table(const ReportInput& input, bool are_details, const std::string& summary) {
  const Quantities quantities = quantities_of(input, are_details);
  if (quantities.empty()) return "";
  mustache::data headings(mustache::data::type::list);
  for (const SweepQuantity& quantity : quantities) headings << spelt(quantity.heading);
  mustache::data conditions(mustache::data::type::list);
  for (int c = 0; c < condition_count(input.study); ++c) {
    conditions << condition_group(input, quantities, c);
  }
  const bool has_intervals =
      std::any_of(quantities.begin(), quantities.end(),
                  [](const SweepQuantity& q) { return q.interval != nullptr; });
  return mustache::mustache(page_text("sweep_table.mustache"))
      .render(mustache::object{
          {"summary", summary},
          {"what", is_orientation(input.study) ? "method" : "solver"},
          {"has_intervals", has_intervals},
          {"headings", headings},
          {"columns", fmt::to_string(quantities.size() + 1)},
          {"conditions", conditions},
      });
}

mustache::data worst(const ReportInput& input, const SweepQuantity& quantity,
                     const std::string& solver) {
  double value = ErrorSummary::kNone;
  std::string where;
  for (int condition = 0; condition < condition_count(input.study); ++condition) {
    const double here = quantity.value(cell_at(input.summary, condition, solver));
    const bool is_worse = quantity.is_better_high ? here < value : here > value;
    if (!is_worse && !(std::isnan(value) && !std::isnan(here))) continue;
    value = here;
    where = input.study.conditions[condition].label;
  }
  return mustache::object{{"value", fixed(value, sweep_decimals(input.summary, quantity))},
                          {"where", where.empty() ? "" : "at " + where}};
}

// A method beside the first of the study.
struct Comparison {
  double greatest_difference_deg = 0;
  double least_time_ratio = ErrorSummary::kNone;
  double greatest_time_ratio = ErrorSummary::kNone;
};

Comparison compare(const ReportInput& input, const std::string& method, const std::string& peer) {
  Comparison comparison;
  for (int condition = 0; condition < condition_count(input.study); ++condition) {
    const CellSummary& a = cell_at(input.summary, condition, method);
    const CellSummary& b = cell_at(input.summary, condition, peer);
    if (a.trials == 0) continue;
    comparison.greatest_difference_deg =
        std::max(comparison.greatest_difference_deg,
                 std::abs(a.angle_error_deg.mean - b.angle_error_deg.mean));
    const double time_ratio = a.time_ns.mean / b.time_ns.mean;
    comparison.least_time_ratio = std::fmin(comparison.least_time_ratio, time_ratio);
    comparison.greatest_time_ratio = std::fmax(comparison.greatest_time_ratio, time_ratio);
  }
  return comparison;
}

mustache::object answer_row(const ReportInput& input, const std::string& solver) {
  mustache::data cells(mustache::data::type::list);
  for (const SweepQuantity& quantity : sweep_quantities(input.study, input.summary)) {
    if (!quantity.is_detail) cells << worst(input, quantity, solver);
  }
  const TrialSolver* const pose_solver = input.study.find_solver(solver);
  mustache::object row = {
      {"solver", label_in(input.study, solver)},
      {"cells", cells},
      {"evaluation_only", pose_solver != nullptr && pose_solver->evaluation_only}};
  const Comparison comparison = compare(input, solver, input.study.solver_names().front());
  row["difference"] = fmt::format("{:.1e}", comparison.greatest_difference_deg);
  row["times"] = fmt::format("{} to {}", fixed(comparison.least_time_ratio, 2),
                             fixed(comparison.greatest_time_ratio, 2));
  return row;
}

// "Time / ns, mean of the draws" without what comes after the unit, if that is short.
std::string axis_title(const std::string& heading) {
  constexpr size_t kLongest = 40;
  const std::string title = heading.substr(0, heading.find(','));
  return title.size() > kLongest ? "" : title;
}

// Adds a point where there is a number.
void add_point(ChartSeries& series, double x, double y) {
  if (std::isnan(y)) return;
  series.x.push_back(x);
  series.y.push_back(y);
}

ChartSeries solver_series(const ReportInput& input, const SweepQuantity& quantity,
                          const SweepPanel& panel, size_t solver) {
  const std::vector<std::string> solvers = input.study.solver_names();
  ChartSeries series{.label = label_in(input.study, solvers[solver]),
                     .style = static_cast<int>(solver)};
  for (size_t i = 0; i < panel.conditions.size(); ++i) {
    const CellSummary& cell = cell_at(input.summary, panel.conditions[i], solvers[solver]);
    const double y = quantity.value(cell);
    if (std::isnan(y)) continue;
    const bool is_of_words = !panel.axis.names.empty();
    add_point(series, is_of_words ? beside(panel.x[i], solver, solvers.size()) : panel.x[i], y);
    if (quantity.interval == nullptr) continue;
    series.low.push_back(quantity.interval(cell)[0]);
    series.high.push_back(quantity.interval(cell)[1]);
  }
  return series;
}

ChartSeries bound_series(const ReportInput& input, const SweepQuantity& quantity,
                         const SweepPanel& panel) {
  ChartSeries series{.label = "bound"};
  for (size_t i = 0; i < panel.conditions.size(); ++i) {
    const CellObservations* found = find_observations(input.summary, panel.conditions[i]);
    if (found != nullptr) add_point(series, panel.x[i], found->*quantity.bound);
  }
  return series;
}

// What the paper prints for a solver, in the place of ours.
ChartSeries paper_series(const ReportInput& input, const SweepQuantity& quantity,
                         const SweepPanel& panel, size_t solver) {
  const std::vector<std::string> solvers = input.study.solver_names();
  ChartSeries series{.label = label_in(input.study, solvers[solver]) + " in the paper",
                     .style = static_cast<int>(solver),
                     .is_from_paper = true};
  for (size_t i = 0; i < panel.conditions.size(); ++i) {
    const Condition& condition = input.study.conditions[panel.conditions[i]];
    const PaperFigure* figure = paper_figure(condition, solvers[solver]);
    if (figure == nullptr) continue;
    add_point(series, beside(panel.x[i], solver, solvers.size()), figure->*quantity.paper);
  }
  return series;
}

Chart chart_of(const ReportInput& input, const SweepQuantity& quantity, const SweepPanel& panel) {
  Chart chart;
  chart.kind = panel.axis.names.empty() ? ChartKind::kLines : ChartKind::kPoints;
  chart.title = spelt(quantity.heading);
  chart.option = panel.option;
  chart.x = panel.axis;
  chart.y.label = axis_title(chart.title);
  if (quantity.interval != nullptr) chart.note = "95 % intervals of the mean.";
  std::vector<ChartSeries> series;
  for (size_t s = 0; s < input.study.solver_names().size(); ++s) {
    series.push_back(solver_series(input, quantity, panel, s));
    if (quantity.paper != nullptr) {
      series.push_back(paper_series(input, quantity, panel, s));
    }
  }
  if (has_bound(quantity)) series.push_back(bound_series(input, quantity, panel));
  for (ChartSeries& part : series) {
    if (!part.x.empty()) chart.series.push_back(std::move(part));
  }
  choose_y_scale(chart);
  return chart;
}

}  // namespace

std::string sweep_answer(const ReportInput& input) {
  const Study& study = input.study;
  mustache::data headings(mustache::data::type::list);
  for (const SweepQuantity& quantity : sweep_quantities(study, input.summary)) {
    if (!quantity.is_detail) headings << spelt(quantity.heading);
  }
  const std::vector<std::string> solvers = study.solver_names();
  const std::vector<std::string> verdicts = claim_verdicts(study, input.summary);
  mustache::data rows(mustache::data::type::list);
  for (const std::string& solver : solvers) rows << mustache::data(answer_row(input, solver));
  return mustache::mustache(page_text("sweep_answer.mustache"))
      .render(mustache::object{
          {"has_question", !study.question.empty()},
          {"question", study.question},
          {"has_claim", !study.claim.empty()},
          {"claim", study.claim},
          {"has_verdict", !verdicts.empty()},
          {"verdict", fmt::to_string(fmt::join(verdicts, " "))},
          {"trials", counted(trials_of(input.summary), "trial")},
          {"conditions", counted(condition_count(study), "condition")},
          {"what", is_orientation(study) ? "Method" : "Solver"},
          {"headings", headings},
          {"has_peer", is_orientation(study) && solvers.size() > 1},
          {"peer", solvers.empty() ? "" : label_in(study, solvers.front())},
          {"is_timed", is_timed(study)},
          {"rows", rows},
          {"angle_cap", fmt::to_string(kAngleCapDeg)},
          {"t_cap", fmt::to_string(kTranslationCapPercent)},
      });
}

std::string sweep_figure(const ReportInput& input) {
  if (input.study.images() != nullptr) return "";  // its table has the numbers
  return table(input, false, "All numbers") + table(input, true, "More of the same conditions");
}

std::vector<Chart> sweep_charts(const ReportInput& input) {
  std::vector<Chart> charts;
  size_t number = 0;
  for (const SweepQuantity& quantity : quantities_of(input, false)) {
    const std::string group = fmt::format("sweep-{}", ++number);
    size_t panel_number = 0;
    for (const SweepPanel& panel : sweep_panels(input.study)) {
      Chart& chart = charts.emplace_back(chart_of(input, quantity, panel));
      chart.group = group;
      chart.id = chart_id(group, panel_number++);
    }
  }
  return charts;
}

}  // namespace sightline
