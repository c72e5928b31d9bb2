// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "eval/report/chart.h"
#include "eval/report/report.h"

namespace sightline {

/// Errors of which a chart draws the distribution; infinite where there is no pose.
struct ErrorSample {
  std::string label;
  int style = 0;  ///< of its curve or box: ChartSeries::style
  std::vector<double> errors;
};

/// Which part of each sample errs by less than so much, up to the cap: a curve a sample. Samples
/// without errors are left out. `error` names what is on the axis.
Chart cumulative_chart(const std::string& error, double cap,
                       const std::vector<ErrorSample>& samples);

/// How each sample spreads: a box each, where what is beyond the cap is drawn at it.
Chart box_chart(const std::string& error, double cap, const std::vector<ErrorSample>& samples);

using DistributionChart = Chart (*)(const std::string& error, double cap,
                                    const std::vector<ErrorSample>& samples);

/// Such a chart of each error that a study is judged by, for each group of its trials: a sample a
/// solver. Charts without any are left out. `name` begins their ids.
std::vector<Chart> distribution_charts(const ReportInput& input, const std::string& name,
                                       DistributionChart chart_of);

}  // namespace sightline
