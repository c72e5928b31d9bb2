// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Every solver against one of them on the same trials, so that what the trials have in common
// cancels: the mean difference of the capped errors, with its interval.
#include <algorithm>
#include <array>
#include <vector>

#include <fmt/format.h>

#include "eval/report/figures.h"
#include "eval/report/means.h"
#include "eval/report/panels.h"
#include "eval/statistics/bootstrap.h"

namespace sightline {
namespace {

size_t reference_solver(const Study& study) {
  const std::vector<std::string> solvers = study.solver_names();
  const auto lead = std::find(solvers.begin(), solvers.end(), lead_solver(study));
  return lead == solvers.end() ? 0 : static_cast<size_t>(lead - solvers.begin());
}

// Of the trials of one condition; -1 for all of them.
std::vector<double> differences(const ReportInput& input, const TrialError& error, int condition,
                                size_t solver, size_t reference) {
  std::vector<double> all;
  const TrialGroup group{"", condition};
  for (const TrialRecord& trial : input.trials) {
    if (!group.holds(trial)) continue;
    all.push_back(std::min(error.of(trial, solver), error.cap) -
                  std::min(error.of(trial, reference), error.cap));
  }
  return all;
}

void add_point(ChartSeries& series, double x, const std::vector<double>& values, uint64_t seed,
               const std::string& stream) {
  if (values.size() < 2) return;
  double sum = 0;
  for (const double value : values) sum += value;
  const std::array<double, 2> interval = bca_mean_interval(values, seed, stream);
  series.x.push_back(x);
  series.y.push_back(sum / static_cast<double>(values.size()));
  series.low.push_back(interval[0]);
  series.high.push_back(interval[1]);
  series.count.push_back(static_cast<double>(values.size()));
}

// A study with one condition has its solvers side by side.
std::vector<SweepPanel> panels_of(const Study& study, size_t reference) {
  std::vector<SweepPanel> panels = sweep_panels(study);
  if (!panels.empty()) return panels;
  SweepPanel panel;
  const std::vector<std::string> solvers = study.solver_names();
  for (size_t s = 0; s < solvers.size(); ++s) {
    if (s != reference) panel.axis.names.push_back(label_in(study, solvers[s]));
  }
  return {panel};
}

Chart chart_of(const ReportInput& input, const TrialError& error, const SweepPanel& panel,
               size_t reference) {
  const Study& study = input.study;
  const std::vector<std::string> solvers = study.solver_names();
  const std::string peer = label_in(study, solvers[reference]);
  Chart chart;
  chart.kind = panel.axis.names.empty() ? ChartKind::kLines : ChartKind::kPoints;
  chart.title = fmt::format("{}: mean difference from {} on the same trials", error.label, peer);
  chart.note = fmt::format("Below zero: smaller errors than {}. 95 % intervals of the mean.", peer);
  chart.option = panel.option;
  chart.x = panel.axis;
  chart.y.label = error.label + ", less that of " + peer;
  for (size_t s = 0; s < solvers.size(); ++s) {
    if (s == reference) continue;
    const size_t place = s - (s > reference ? 1 : 0);
    ChartSeries series{.label = label_in(study, solvers[s]), .style = static_cast<int>(s)};
    const auto add = [&](double x, int condition) {
      add_point(series, x, differences(input, error, condition, s, reference), study.seed,
                fmt::format("report/paired/{}/{}/{}", error.id, solvers[s], condition));
    };
    if (panel.conditions.empty()) add(static_cast<double>(place), -1);
    for (size_t i = 0; i < panel.conditions.size(); ++i) {
      const bool is_of_words = chart.kind == ChartKind::kPoints;
      add(is_of_words ? beside(panel.x[i], place, solvers.size() - 1) : panel.x[i],
          panel.conditions[i]);
    }
    if (!series.x.empty()) chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

std::vector<Chart> paired_charts(const ReportInput& input) {
  if (input.study.solver_names().size() < 2) return {};
  const size_t reference = reference_solver(input.study);
  std::vector<Chart> charts;
  for (const TrialError& error : trial_errors(input.study)) {
    size_t number = 0;
    for (const SweepPanel& panel : panels_of(input.study, reference)) {
      Chart chart = chart_of(input, error, panel, reference);
      chart.group = "paired-" + error.id;
      chart.id = chart_id(chart.group, number++);
      if (!chart.series.empty()) charts.push_back(std::move(chart));
    }
  }
  return charts;
}

}  // namespace sightline
