// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which part of the trials errs by less than so much: a curve a solver. A trial without a pose is
// in the whole and never under a curve.
#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "eval/report/figures.h"
#include "eval/report/panels.h"

namespace sightline {
namespace {

constexpr size_t kMostSteps = 200;  // of a curve: finer than a screen can show

// The steps of the distribution of sorted errors up to the cap, where it ends.
ChartSeries curve(const std::vector<double>& sorted, double cap) {
  ChartSeries series;
  const size_t count = sorted.size();
  const size_t steps = std::min(count, kMostSteps);
  double percent = 0;
  for (size_t k = 1; k <= steps; ++k) {
    const size_t below = (k * count + steps - 1) / steps;  // trials up to this step
    const double error = sorted[below - 1];
    if (!(error < cap)) break;
    if (series.x.empty()) {
      series.x.push_back(sorted.front());
      series.y.push_back(0);
    }
    percent = 100.0 * static_cast<double>(below) / static_cast<double>(count);
    series.x.push_back(error);
    series.y.push_back(percent);
  }
  series.x.push_back(cap);
  series.y.push_back(percent);
  return series;
}

Chart chart_of(const ReportInput& input, const TrialError& error, const TrialGroup& group) {
  Chart chart;
  chart.kind = ChartKind::kSteps;
  chart.title = fmt::format("{}: how many trials err by less", error.label);
  chart.note = fmt::format(
      "Errors end at {}; a trial without a pose counts in the whole and errs by more.", error.cap);
  chart.option = group.option;
  chart.x.label = error.label;
  chart.y = {.label = "trials, %", .low = 0, .high = 100};
  std::vector<double> all;
  const std::vector<std::string> solvers = input.study.solver_names();
  for (size_t s = 0; s < solvers.size(); ++s) {
    std::vector<double> errors;
    for (const TrialRecord& trial : input.trials) {
      if (group.holds(trial)) errors.push_back(error.of(trial, s));
    }
    if (errors.empty()) continue;
    std::sort(errors.begin(), errors.end());
    ChartSeries& series = chart.series.emplace_back(curve(errors, error.cap));
    series.label = label_in(input.study, solvers[s]);
    series.style = static_cast<int>(s);
    all.insert(all.end(), series.x.begin(), series.x.end());
  }
  choose_scale(chart.x, all);
  chart.x.high = error.cap;
  return chart;
}

}  // namespace

std::vector<Chart> cumulative_charts(const ReportInput& input) {
  std::vector<Chart> charts;
  for (const TrialError& error : trial_errors(input.study)) {
    size_t number = 0;
    for (const TrialGroup& group : trial_groups(input.study)) {
      Chart chart = chart_of(input, error, group);
      chart.group = "cumulative-" + error.id;
      chart.id = chart_id(chart.group, number++);
      if (!chart.series.empty()) charts.push_back(std::move(chart));
    }
  }
  return charts;
}

}  // namespace sightline
