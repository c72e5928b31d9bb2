// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Which part of the trials errs by less than so much: a curve a solver. A trial without a pose is
// in the whole and never under a curve.
#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "eval/report/distributions.h"
#include "eval/report/figures.h"

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

}  // namespace

Chart cumulative_chart(const std::string& error, double cap,
                       const std::vector<ErrorSample>& samples) {
  Chart chart;
  chart.kind = ChartKind::kSteps;
  chart.title = fmt::format("{}: how many trials err by less", error);
  chart.note = fmt::format(
      "Errors end at {}; a trial without a pose counts in the whole and errs by more.", cap);
  chart.x.label = error;
  chart.y = {.label = "trials, %", .low = 0, .high = 100};
  std::vector<double> all;
  for (const ErrorSample& sample : samples) {
    if (sample.errors.empty()) continue;
    std::vector<double> sorted = sample.errors;
    std::sort(sorted.begin(), sorted.end());
    ChartSeries& series = chart.series.emplace_back(curve(sorted, cap));
    series.label = sample.label;
    series.style = sample.style;
    all.insert(all.end(), series.x.begin(), series.x.end());
  }
  choose_scale(chart.x, all);
  chart.x.high = cap;
  return chart;
}

std::vector<Chart> cumulative_charts(const ReportInput& input) {
  return distribution_charts(input, "cumulative", cumulative_chart);
}

}  // namespace sightline
