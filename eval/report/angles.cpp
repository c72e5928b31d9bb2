// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The error over the plane of pitch and yaw, which say from where the target is seen: a heat map a
// solver, all in the same colours. Not where the poses are given: there are too few.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "eval/output/numbers.h"
#include "eval/report/figures.h"
#include "eval/report/panels.h"
#include "eval/statistics/statistics.h"

namespace sightline {
namespace {

constexpr double kTrialsACell = 8;  // that a median needs to say anything
constexpr int kLeastCells = 3;      // a side
constexpr int kMostCells = 12;

// Equal parts of a range of angles.
struct Bins {
  double low = 0;
  double size = 1;
  int count = 1;

  int of(double value) const {
    return std::clamp(static_cast<int>(std::floor((value - low) / size)), 0, count - 1);
  }
  double centre(int bin) const { return low + (bin + 0.5) * size; }
};

struct Grid {
  Bins pitch;
  Bins yaw;
  /// Trials by cell, yaw by yaw.
  std::vector<std::vector<const TrialRecord*>> trials;
};

Eigen::Vector3d angles_of(const TrialRecord& trial) {
  return attitude_deg(trial.true_cam_from_target.rotation);
}

// Over what the angles span, in steps of five degrees.
Bins bins_over(const std::vector<Eigen::Vector3d>& angles, int axis, int count) {
  constexpr double kStepDeg = 5;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Eigen::Vector3d& angle : angles) {
    low = std::min(low, angle[axis]);
    high = std::max(high, angle[axis]);
  }
  low = kStepDeg * std::floor(low / kStepDeg);
  high = std::max(kStepDeg * std::ceil(high / kStepDeg), low + kStepDeg);
  return {low, (high - low) / count, count};
}

Grid grid_of(std::span<const TrialRecord> trials) {
  std::vector<Eigen::Vector3d> angles;
  for (const TrialRecord& trial : trials) angles.push_back(angles_of(trial));
  const double side = std::sqrt(static_cast<double>(trials.size()) / kTrialsACell);
  const int count = std::clamp(static_cast<int>(side), kLeastCells, kMostCells);
  Grid grid{bins_over(angles, 0, count), bins_over(angles, 1, count), {}};
  grid.trials.resize(static_cast<size_t>(count) * count);
  for (size_t i = 0; i < trials.size(); ++i) {
    const int cell = grid.yaw.of(angles[i].y()) * count + grid.pitch.of(angles[i].x());
    grid.trials[cell].push_back(&trials[i]);
  }
  return grid;
}

ChartSeries cells_of(const Grid& grid, const TrialError& error, size_t solver) {
  ChartSeries series;
  for (int yaw = 0; yaw < grid.yaw.count; ++yaw) {
    for (int pitch = 0; pitch < grid.pitch.count; ++pitch) {
      const auto& trials = grid.trials[static_cast<size_t>(yaw) * grid.pitch.count + pitch];
      if (trials.empty()) continue;
      std::vector<double> errors;
      for (const TrialRecord* trial : trials) errors.push_back(error.of(*trial, solver));
      series.x.push_back(grid.pitch.centre(pitch));
      series.y.push_back(grid.yaw.centre(yaw));
      series.value.push_back(std::min(percentile(errors, 0.5), error.cap));
      series.count.push_back(static_cast<double>(errors.size()));
    }
  }
  return series;
}

ChartAxis axis_over(const std::string& label, const Bins& bins) {
  return {.label = label, .low = bins.low, .high = bins.low + bins.count * bins.size};
}

}  // namespace

std::vector<Chart> angles_charts(const ReportInput& input) {
  const Study& study = input.study;
  const PoseLaw* const poses = study.pose_law();
  const bool has_drawn_poses = poses != nullptr && poses->theta_deg.empty();
  if (!has_drawn_poses || input.trials.empty()) return {};
  const TrialError error = geodesic_error();
  const Grid grid = grid_of(input.trials);
  std::vector<Chart> charts;
  std::vector<double> values;
  const std::vector<std::string> solvers = study.solver_names();
  for (size_t s = 0; s < solvers.size(); ++s) {
    Chart& chart = charts.emplace_back();
    chart.kind = ChartKind::kCells;
    chart.group = "angles";
    chart.id = chart_id(chart.group, s);
    chart.option = label_in(study, solvers[s]);
    chart.title = "Geodesic error, median of a cell’s trials, by pitch and yaw";
    chart.note = fmt::format(
        "All conditions together. A trial without a pose is infinitely wrong: {0}° stands for {0}° "
        "and more. Cells without trials are left empty.",
        error.cap);
    chart.x = axis_over("true pitch, °", grid.pitch);
    chart.y = axis_over("true yaw, °", grid.yaw);
    chart.cell_size = {grid.pitch.size, grid.yaw.size};
    ChartSeries& series = chart.series.emplace_back(cells_of(grid, error, s));
    series.label = chart.option;
    series.style = static_cast<int>(s);
    values.insert(values.end(), series.value.begin(), series.value.end());
  }
  ChartAxis colours{.label = error.label};
  choose_scale(colours, values);
  if (!colours.is_log) colours.low = 0;
  colours.high = *std::max_element(values.begin(), values.end());
  for (Chart& chart : charts) chart.value = colours;
  return charts;
}

}  // namespace sightline
