// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/tables/sweep_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/numbers.h"
#include "eval/output/text_table.h"

namespace sightline {
namespace {

constexpr size_t kLongestSweptLabel = 30;
constexpr double kLeastShown = 0.01;  // smaller values do not ask for more decimals

using Cell = CellSummary;

// A member's mean with its interval.
template <ErrorSummary Cell::*kError>
SweepQuantity mean_of(const std::string& heading) {
  return {.heading = heading,
          .value = [](const Cell& cell) { return (cell.*kError).mean; },
          .interval = [](const Cell& cell) -> const std::array<double, 2>& {
            return (cell.*kError).mean_ci95;
          }};
}

template <double Cell::*kMember>
SweepQuantity number_of(const std::string& heading) {
  return {.heading = heading, .value = [](const Cell& cell) { return cell.*kMember; }};
}

SweepQuantity in_detail(SweepQuantity quantity) {
  quantity.is_detail = true;
  return quantity;
}

bool has_oracle(const NumericStudy& study) {
  const std::vector<const PoseSolver*>& solvers = study.solving.solvers;
  return std::any_of(solvers.begin(), solvers.end(),
                     [](const PoseSolver* solver) { return solver->name == "oracle"; });
}

std::vector<SweepQuantity> numeric_quantities(const NumericStudy& study) {
  // The bound is of an RMS error and stands beside nothing else.
  std::vector<SweepQuantity> all = {
      mean_of<&Cell::theta_error_deg>("theta_error / °, mean of the trials"),
      mean_of<&Cell::t_error_percent>("T_error / % of the distance, mean of the trials"),
      {.heading = "Geodesic error / °, RMS of the trials",
       .value = [](const Cell& cell) { return cell.geodesic_deg.rms; },
       .bound = &CellObservations::bound_geodesic_deg}};
  if (has_oracle(study)) {
    all.push_back(number_of<&Cell::ratio_to_oracle>(
        "RMS geodesic error over that of least squares on the true inliers"));
  }
  all.push_back({.heading = "Trials in which exactly the outliers were removed / %",
                 .value = [](const Cell& cell) { return 100 * cell.exact_set_rate; },
                 .is_better_high = true,
                 .decimals = 1});
  all.push_back(in_detail(number_of<&Cell::ratio_to_bound>("RMS geodesic error over the bound")));
  all.push_back(in_detail(number_of<&Cell::false_removals>("Inliers removed a trial")));
  all.push_back(in_detail(number_of<&Cell::missed_outliers>("Outliers kept a trial")));
  all.push_back({.heading = "Trials without a pose / %",
                 .value = [](const Cell& cell) { return 100.0 * cell.failures / cell.trials; },
                 .is_detail = true,
                 .decimals = 1});
  return all;
}

std::vector<SweepQuantity> orientation_quantities(const OrientationStudy& study,
                                                  const Summary& summary) {
  std::vector<SweepQuantity> all;
  if (study.takes_times()) {
    all.push_back(mean_of<&Cell::time_ns>("Time of a solve / ns, mean of the draws"));
  }
  all.push_back(
      mean_of<&Cell::angle_error_deg>("Error of an Euler angle / °, absolute, mean of the three"));
  all.push_back(mean_of<&Cell::geodesic_deg>("Geodesic error / °, mean"));
  all.push_back(in_detail(mean_of<&Cell::theta_error_deg>("theta_error / °, mean")));
  all.push_back(in_detail(mean_of<&Cell::t_error_percent>("T_error / % of the distance, mean")));
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
  std::vector<std::string> labels;
  for (const Condition& c : study.conditions)
    labels.push_back(shortened(c.label, kLongestSweptLabel));
  std::vector<TextGroup> groups;
  for (const std::string& solver : study.solver_names()) {
    TextColumn column{solver, {}};
    for (int condition = 0; condition < conditions; ++condition) {
      const double value = quantity.value(sweep_cell(summary, condition, solver));
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
  return text_block(quantity.heading, labels, groups);
}

// "orpe's mean theta_error is below 2 degrees but in 3 px and 4 px".
std::string limit_verdict(const Study& study, const Summary& summary, const std::string& solver,
                          ErrorSummary Cell::*error, const std::string& what, double limit,
                          const std::string& unit) {
  std::vector<std::string> beyond;
  for (size_t i = 0; i < study.conditions.size(); ++i) {
    const double mean = (sweep_cell(summary, static_cast<int>(i), solver).*error).mean;
    if (mean >= limit) beyond.push_back(study.conditions[i].label);
  }
  std::string text = fmt::format("{}'s mean {} is below {:g} {}", solver, what, limit, unit);
  if (beyond.empty()) return text + " in every condition.";
  if (beyond.size() == study.conditions.size()) return text + " in no condition.";
  return fmt::format("{} but at {}.", text, fmt::join(beyond, ", "));
}

std::vector<std::string> limit_verdicts(const Study& study, const Summary& summary,
                                        const ClaimLimits& limits) {
  const std::vector<std::string> solvers = study.solver_names();
  if (std::find(solvers.begin(), solvers.end(), limits.solver) == solvers.end()) return {};
  return {limit_verdict(study, summary, limits.solver, &Cell::theta_error_deg, "theta_error",
                        limits.theta_error_deg, "degrees"),
          limit_verdict(study, summary, limits.solver, &Cell::t_error_percent, "T_error",
                        limits.t_error_percent, "percent")};
}

struct Range {
  double least = std::numeric_limits<double>::infinity();
  double most = 0;

  void add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
};

// The paper's two methods held against each other.
std::vector<std::string> pair_verdicts(const Study& study, const Summary& summary) {
  constexpr const char* kFast = "fast";
  constexpr const char* kUmeyama = "umeyama";
  const std::vector<std::string> methods = study.solver_names();
  for (const char* method : {kFast, kUmeyama}) {
    if (std::find(methods.begin(), methods.end(), method) == methods.end()) return {};
  }
  Range error, time;
  for (int i = 0; i < static_cast<int>(study.conditions.size()); ++i) {
    const Cell fast = sweep_cell(summary, i, kFast);
    const Cell umeyama = sweep_cell(summary, i, kUmeyama);
    if (umeyama.angle_error_deg.mean > 0) {
      error.add(fast.angle_error_deg.mean / umeyama.angle_error_deg.mean);
    }
    if (fast.time_ns.mean > 0) time.add(umeyama.time_ns.mean / fast.time_ns.mean);
  }
  std::vector<std::string> verdicts;
  if (error.most > 0) {
    verdicts.push_back(fmt::format("{} errs {:.4f} to {:.4f} times as much as {}.", kFast,
                                   error.least, error.most, kUmeyama));
  }
  if (study.takes_times() && time.most > 0) {
    verdicts.push_back(fmt::format("{} takes {:.1f} to {:.1f} times as long as {}.", kUmeyama,
                                   time.least, time.most, kFast));
  }
  return verdicts;
}

}  // namespace

std::vector<SweepQuantity> sweep_quantities(const Study& study, const Summary& summary) {
  if (const NumericStudy* const numeric = study.numeric()) return numeric_quantities(*numeric);
  if (const OrientationStudy* const orientation = study.orientation()) {
    return orientation_quantities(*orientation, summary);
  }
  return {};
}

CellSummary sweep_cell(const Summary& summary, int condition, const std::string& solver) {
  for (const CellSummary& cell : summary.cells) {
    if (cell.condition == condition && cell.solver == solver) return cell;
  }
  return {};
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

std::vector<std::string> claim_verdicts(const Study& study, const Summary& summary) {
  const NumericStudy* const numeric = study.numeric();
  if (numeric != nullptr && numeric->limits) {
    return limit_verdicts(study, summary, *numeric->limits);
  }
  if (study.orientation() != nullptr) return pair_verdicts(study, summary);
  return {};
}

std::string sweep_blocks(const Study& study, const Summary& summary) {
  std::string text;
  for (const SweepQuantity& quantity : sweep_quantities(study, summary)) {
    if (!quantity.is_detail) text += block(study, summary, quantity);
  }
  return text + "\n" + wrapped("The 95 % intervals of the means stand in the report.");
}

}  // namespace sightline
