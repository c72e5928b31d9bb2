// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/cells.h"

#include <cmath>

#include <gtest/gtest.h>

#include "eval/summary/summary.h"

namespace sightline {
namespace {

// Two cells of a solver with these means; the second condition may have no trials.
Summary two_cells(double first, double second, int trials_of_second) {
  Summary summary;
  for (int i = 0; i < 2; ++i) {
    CellSummary& cell = summary.cells.emplace_back();
    cell.condition = i;
    cell.solver = "lspe";
    cell.trials = i == 0 ? 10 : trials_of_second;
    cell.theta_error_deg.mean = i == 0 ? first : second;
    cell.theta_error_deg.mean_ci95 = {cell.theta_error_deg.mean - 3,
                                      cell.theta_error_deg.mean + (i == 0 ? 6 : 8)};
    cell.ratio_to_bound = cell.theta_error_deg.mean;
    CellObservations& observations = summary.observations.emplace_back();
    observations.condition = i;
    observations.trials = cell.trials;
    observations.found = cell.theta_error_deg.mean;
  }
  return summary;
}

TEST(Cells, AreFoundByConditionAndSolver) {
  const Summary summary = two_cells(1, 2, 10);
  ASSERT_NE(find_cell(summary, 1, "lspe"), nullptr);
  EXPECT_EQ(find_cell(summary, 1, "lspe"), &cell_at(summary, 1, "lspe"));
  EXPECT_EQ(find_cell(summary, 1, "orpe"), nullptr);
  EXPECT_TRUE(std::isnan(cell_at(summary, 1, "orpe").theta_error_deg.mean));
  EXPECT_EQ(cells_of(summary, "lspe").size(), 2u);
  EXPECT_EQ(find_observations(summary, 2), nullptr);
}

TEST(MeanOverConditions, WeighsThoseThatHaveTrialsAlike) {
  const Summary both = two_cells(1, 2, 1);
  EXPECT_DOUBLE_EQ(mean_over_conditions(both, &CellObservations::found), 1.5);
  EXPECT_DOUBLE_EQ(mean_over_conditions(both, "lspe", &CellSummary::ratio_to_bound), 1.5);
  const Summary one = two_cells(1, 2, 0);
  EXPECT_DOUBLE_EQ(mean_over_conditions(one, &CellObservations::found), 1);
  EXPECT_DOUBLE_EQ(mean_over_conditions(one, "lspe", &CellSummary::ratio_to_bound), 1);
  EXPECT_EQ(conditions_with_trials(one), 1);
  EXPECT_EQ(trials_of(one), 10);
  EXPECT_TRUE(std::isnan(mean_over_conditions(Summary{}, &CellObservations::found)));
}

TEST(MeanOverConditions, AddsHalfWidthsAsSquares) {
  const Measured mean =
      mean_over_conditions(two_cells(1, 2, 10), "lspe", &CellSummary::theta_error_deg);
  EXPECT_DOUBLE_EQ(mean.value, 1.5);
  EXPECT_DOUBLE_EQ(mean.ci95[0], 1.5 - std::sqrt(18.0) / 2);
  EXPECT_DOUBLE_EQ(mean.ci95[1], 1.5 + 10.0 / 2);
  const Measured none = mean_over_conditions(Summary{}, "lspe", &CellSummary::theta_error_deg);
  EXPECT_TRUE(std::isnan(none.value));
}

}  // namespace
}  // namespace sightline
