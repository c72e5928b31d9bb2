// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Box plots: how the errors of each solver spread.
#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "eval/report/figures.h"
#include "eval/report/panels.h"
#include "eval/statistics.h"

namespace sightline {
namespace {

// Failures are infinite, and with whatever is beyond the cap they are drawn at it.
ChartSeries box(const std::vector<double>& errors, double cap, size_t place) {
  const auto at = [&](double p) { return std::min(percentile(errors, p), cap); };
  return {.label = "",
          .style = static_cast<int>(place),
          .x = {static_cast<double>(place)},
          .y = {at(0.5)},
          .low = {at(0.25)},
          .high = {at(0.75)},
          .least = {at(0.05)},
          .most = {at(0.95)},
          .count = {static_cast<double>(errors.size())}};
}

Chart chart_of(const ReportInput& input, const TrialError& error, const TrialGroup& group) {
  Chart chart;
  chart.kind = ChartKind::kBoxes;
  chart.title = fmt::format("{}: its spread", error.label);
  chart.note = fmt::format(
      "Line: median. Box: the middle half of the trials. Whiskers: 5 % and 95 %. What is beyond "
      "{}, "
      "a trial without a pose too, is drawn there.",
      error.cap);
  chart.option = group.option;
  chart.y.label = error.label;
  const std::vector<std::string> solvers = input.study.solver_names();
  for (size_t s = 0; s < solvers.size(); ++s) {
    chart.x.names.push_back(label_in(input.study, solvers[s]));
    std::vector<double> errors;
    for (const TrialRecord& trial : input.trials) {
      if (group.holds(trial)) errors.push_back(error.of(trial, s));
    }
    if (errors.empty()) continue;
    ChartSeries& series = chart.series.emplace_back(box(errors, error.cap, s));
    series.label = chart.x.names.back();
  }
  choose_y_scale(chart);
  return chart;
}

}  // namespace

std::vector<Chart> boxes_charts(const ReportInput& input) {
  std::vector<Chart> charts;
  for (const TrialError& error : trial_errors(input.study)) {
    size_t number = 0;
    for (const TrialGroup& group : trial_groups(input.study)) {
      Chart chart = chart_of(input, error, group);
      chart.group = "boxes-" + error.id;
      chart.id = chart_id(chart.group, number++);
      if (!chart.series.empty()) charts.push_back(std::move(chart));
    }
  }
  return charts;
}

}  // namespace sightline
