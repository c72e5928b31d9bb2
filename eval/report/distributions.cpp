// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/distributions.h"

#include <utility>

#include <fmt/format.h>

#include "eval/report/panels.h"

namespace sightline {
namespace {

std::vector<ErrorSample> samples_of(const ReportInput& input, const TrialError& error,
                                    const TrialGroup& group) {
  std::vector<ErrorSample> samples;
  const std::vector<std::string> solvers = input.study.solver_names();
  for (size_t s = 0; s < solvers.size(); ++s) {
    ErrorSample& sample = samples.emplace_back(
        ErrorSample{label_in(input.study, solvers[s]), static_cast<int>(s), {}});
    for (const TrialRecord& trial : input.trials) {
      if (group.holds(trial)) sample.errors.push_back(error.of(trial, s));
    }
  }
  return samples;
}

}  // namespace

std::vector<Chart> distribution_charts(const ReportInput& input, const std::string& name,
                                       DistributionChart chart_of) {
  std::vector<Chart> charts;
  for (const TrialError& error : trial_errors(input.study)) {
    size_t number = 0;
    for (const TrialGroup& group : trial_groups(input.study)) {
      Chart chart = chart_of(error.label, error.cap, samples_of(input, error, group));
      chart.option = group.option;
      chart.group = fmt::format("{}-{}", name, error.id);
      chart.id = chart_id(chart.group, number++);
      if (!chart.series.empty()) charts.push_back(std::move(chart));
    }
  }
  return charts;
}

}  // namespace sightline
