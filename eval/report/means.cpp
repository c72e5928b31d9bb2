// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/means.h"

#include <vector>

namespace sightline {
namespace {

std::optional<PaperFigure> mean_paper_figure(const Study& study, const std::vector<int>& conditions,
                                             std::string_view solver) {
  if (conditions.empty()) return std::nullopt;
  PaperFigure mean;
  const double n = static_cast<double>(conditions.size());
  for (const int condition : conditions) {
    const PaperFigure* figure = paper_figure(study.conditions[condition], solver);
    if (figure == nullptr) return std::nullopt;
    mean.theta_error_deg += figure->theta_error_deg / n;
    mean.t_error_percent += figure->t_error_percent / n;
  }
  return mean;
}

}  // namespace

SolverMeans means_over_conditions(const Study& study, const Summary& summary,
                                  std::string_view solver) {
  SolverMeans means;
  means.solver = solver;
  std::vector<int> conditions;
  for (const CellSummary* cell : cells_of(summary, solver)) {
    if (cell->trials == 0) continue;
    conditions.push_back(cell->condition);
    means.trials += cell->trials;
    means.failures += cell->failures;
  }
  means.theta_error_deg = mean_over_conditions(summary, solver, &CellSummary::theta_error_deg);
  means.t_error_percent = mean_over_conditions(summary, solver, &CellSummary::t_error_percent);
  means.paper = mean_paper_figure(study, conditions, solver);
  return means;
}

}  // namespace sightline
