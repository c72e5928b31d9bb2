// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/tables/sweep_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "eval/output/numbers.h"
#include "eval/output/text_table.h"
#include "eval/summary/cells.h"
#include "eval/summary/quantities.h"
#include "eval/tables/labels.h"

namespace sightline {
namespace {

constexpr size_t kLongestSweptLabel = 30;
constexpr double kLeastShown = 0.01;  // smaller values do not ask for more decimals

using Cell = CellSummary;

SweepQuantity shown(const Quantity& quantity, const QuantityView& view) {
  const auto error = quantity.summary;
  return {.heading = view.heading,
          .value = [error](const Cell& cell) { return (cell.*error).mean; },
          .interval = [error](const Cell& cell) { return (cell.*error).mean_ci95; },
          .is_detail = view.is_detail};
}

// The RMS, beside the bound, which is of an RMS error and stands beside nothing else.
SweepQuantity shown_beside_bound(const Quantity& quantity) {
  const auto error = quantity.summary;
  return {.heading = quantity.in_pose_studies.heading,
          .value = [error](const Cell& cell) { return (cell.*error).rms; },
          .bound = quantity.bound,
          .is_detail = quantity.in_pose_studies.is_detail};
}

SweepQuantity number_of(const std::string& heading, double Cell::*member) {
  return {.heading = heading, .value = [member](const Cell& cell) { return cell.*member; }};
}

SweepQuantity in_detail(SweepQuantity quantity) {
  quantity.is_detail = true;
  return quantity;
}

bool has_oracle(const NumericStudy& study) {
  const std::vector<TrialSolver>& solvers = study.solving.solvers;
  return std::any_of(solvers.begin(), solvers.end(),
                     [](const TrialSolver& solver) { return solver.name == "oracle"; });
}

// The errors that the paper prints, with their means and the mean of the bound.
std::vector<SweepQuantity> image_quantities() {
  std::vector<SweepQuantity> all;
  for (const Quantity& quantity : quantities()) {
    if (quantity.paper == nullptr) continue;
    SweepQuantity& one = all.emplace_back(shown(quantity, quantity.in_pose_studies));
    one.bound = quantity.bound;
    one.paper = quantity.paper;
  }
  return all;
}

std::vector<SweepQuantity> numeric_quantities(const NumericStudy& study) {
  std::vector<SweepQuantity> all;
  for (const Quantity& quantity : quantities()) {
    if (quantity.in_pose_studies.heading == nullptr) continue;
    all.push_back(quantity.is_rms ? shown_beside_bound(quantity)
                                  : shown(quantity, quantity.in_pose_studies));
  }
  if (has_oracle(study)) {
    all.push_back(number_of("RMS geodesic error over that of least squares on the true inliers",
                            &Cell::ratio_to_oracle));
  }
  all.push_back({.heading = "Trials in which exactly the outliers were removed / %",
                 .value = [](const Cell& cell) { return 100 * cell.exact_set_rate; },
                 .is_better_high = true,
                 .decimals = 1});
  all.push_back(in_detail(number_of("RMS geodesic error over the bound", &Cell::ratio_to_bound)));
  all.push_back(in_detail(number_of("Inliers removed a trial", &Cell::false_removals)));
  all.push_back(in_detail(number_of("Outliers kept a trial", &Cell::missed_outliers)));
  all.push_back({.heading = "Trials without a pose / %",
                 .value = [](const Cell& cell) { return 100.0 * cell.failures / cell.trials; },
                 .is_detail = true,
                 .decimals = 1});
  return all;
}

std::vector<SweepQuantity> orientation_quantities(const OrientationStudy& study,
                                                  const Summary& summary) {
  std::vector<SweepQuantity> all;
  for (const Quantity& quantity : quantities()) {
    const QuantityView& view = quantity.in_orientation_studies;
    const bool is_measured = !quantity.is_time || study.takes_times();
    if (view.heading != nullptr && is_measured) all.push_back(shown(quantity, view));
  }
  if (study.has_outliers()) {
    all.push_back(
        {.heading = "Draws with a geodesic error at the cap / %",
         .value = [](const Cell& cell) { return 100.0 * cell.geodesic_deg.capped / cell.trials; },
         .decimals = 1});
  }
  const bool has_failures = std::any_of(summary.cells.begin(), summary.cells.end(),
                                        [](const Cell& cell) { return cell.failed_copies > 0; });
  if (has_failures) {
    all.push_back({.heading = "Copies without a rotation, a draw", .value = [](const Cell& cell) {
                     return static_cast<double>(cell.failed_copies) / cell.trials;
                   }});
  }
  return all;
}

std::string block(const Study& study, const Summary& summary, const SweepQuantity& quantity) {
  const int decimals = sweep_decimals(summary, quantity);
  const int conditions = static_cast<int>(study.conditions.size());
  std::vector<TextGroup> groups;
  for (const std::string& solver : study.solver_names()) {
    TextColumn column{solver, {}};
    for (int condition = 0; condition < conditions; ++condition) {
      const double value = quantity.value(cell_at(summary, condition, solver));
      column.cells.push_back(number_text(value, decimals));
    }
    groups.push_back({"", {column}});
  }
  if (quantity.bound != nullptr) {
    TextColumn column{"bound", {}};
    for (const CellObservations& cell : summary.observations) {
      column.cells.push_back(number_text(cell.*quantity.bound, decimals));
    }
    groups.push_back({"", {column}});
  }
  return text_block(quantity.heading, condition_labels(study, kLongestSweptLabel), groups);
}

}  // namespace

std::vector<SweepQuantity> sweep_quantities(const Study& study, const Summary& summary) {
  if (const NumericStudy* const numeric = study.numeric()) return numeric_quantities(*numeric);
  if (const OrientationStudy* const orientation = study.orientation()) {
    return orientation_quantities(*orientation, summary);
  }
  return image_quantities();
}

int sweep_decimals(const Summary& summary, const SweepQuantity& quantity) {
  if (quantity.decimals >= 0) return quantity.decimals;
  double least = std::numeric_limits<double>::infinity();
  for (const CellSummary& cell : summary.cells) {
    const double value = quantity.value(cell);
    if (value >= kLeastShown) least = std::min(least, value);
  }
  if (!std::isfinite(least)) return 2;
  return std::clamp(static_cast<int>(2 - std::floor(std::log10(least))), 0, 3);
}

std::string sweep_blocks(const Study& study, const Summary& summary) {
  std::string text;
  for (const SweepQuantity& quantity : sweep_quantities(study, summary)) {
    if (!quantity.is_detail) text += block(study, summary, quantity);
  }
  return text + "\n" + wrapped("The 95 % intervals of the means stand in the report.");
}

}  // namespace sightline
