// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/claims.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sightline {
namespace {

// "orpe's mean theta_error is below 2 degrees but in 3 px and 4 px".
std::string limit_verdict(const Study& study, const Summary& summary, const std::string& solver,
                          ErrorSummary CellErrors::*error, const std::string& what, double limit,
                          const std::string& unit) {
  std::vector<std::string> beyond;
  for (size_t i = 0; i < study.conditions.size(); ++i) {
    const double mean = (cell_at(summary, static_cast<int>(i), solver).*error).mean;
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
  return {limit_verdict(study, summary, limits.solver, &CellSummary::theta_error_deg, "theta_error",
                        limits.theta_error_deg, "degrees"),
          limit_verdict(study, summary, limits.solver, &CellSummary::t_error_percent, "T_error",
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
    const CellSummary& fast = cell_at(summary, i, kFast);
    const CellSummary& umeyama = cell_at(summary, i, kUmeyama);
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

std::vector<std::string> claim_verdicts(const Study& study, const Summary& summary) {
  const NumericStudy* const numeric = study.numeric();
  if (numeric != nullptr && numeric->limits) {
    return limit_verdicts(study, summary, *numeric->limits);
  }
  if (study.orientation() != nullptr) return pair_verdicts(study, summary);
  return {};
}

}  // namespace sightline
