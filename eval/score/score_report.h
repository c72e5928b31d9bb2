// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "eval/datasets/bop/dataset.h"
#include "eval/datasets/bop/results_csv.h"
#include "eval/report/chart.h"
#include "eval/score/score.h"

namespace sightline {

/// All that the page of a scored results file tells.
struct ScoreReportInput {
  std::string results;  ///< the file's name as it was given
  std::string dataset;  ///< alike
  double vsd_delta_mm = 0;
  const BopDataset& truth;
  std::span<const BopEstimate> estimates;
  const BopScores& scores;
};

/// The charts of the page, in its order.
std::vector<Chart> score_charts(const ScoreReportInput& input);

/// The page: the answer with its intervals, recalls by object and threshold, how our own errors are
/// distributed, the worst estimates, definitions. Self-contained, as a study's.
std::string score_report(const ScoreReportInput& input);

}  // namespace sightline
