// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Box plots: how the errors of each solver spread.
#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "eval/report/distributions.h"
#include "eval/report/figures.h"
#include "eval/statistics/statistics.h"

namespace sightline {
namespace {

// Failures are infinite, and with whatever is beyond the cap they are drawn at it.
ChartSeries box(const ErrorSample& sample, double cap, size_t place) {
  const auto at = [&](double p) { return std::min(percentile(sample.errors, p), cap); };
  return {.label = sample.label,
          .style = sample.style,
          .x = {static_cast<double>(place)},
          .y = {at(0.5)},
          .low = {at(0.25)},
          .high = {at(0.75)},
          .least = {at(0.05)},
          .most = {at(0.95)},
          .count = {static_cast<double>(sample.errors.size())}};
}

}  // namespace

Chart box_chart(const std::string& error, double cap, const std::vector<ErrorSample>& samples) {
  Chart chart;
  chart.kind = ChartKind::kBoxes;
  chart.title = fmt::format("{}: its spread", error);
  chart.note = fmt::format(
      "Line: median. Box: the middle half of the trials. Whiskers: 5 % and 95 %. What is beyond "
      "{}, a trial without a pose too, is drawn there.",
      cap);
  chart.y.label = error;
  for (size_t s = 0; s < samples.size(); ++s) {
    chart.x.names.push_back(samples[s].label);
    if (!samples[s].errors.empty()) chart.series.push_back(box(samples[s], cap, s));
  }
  choose_y_scale(chart);
  return chart;
}

std::vector<Chart> boxes_charts(const ReportInput& input) {
  return distribution_charts(input, "boxes", box_chart);
}

}  // namespace sightline
