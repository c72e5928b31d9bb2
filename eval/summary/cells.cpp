// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/cells.h"

#include <algorithm>
#include <cmath>

#include "eval/summary/summary.h"

namespace sightline {

const CellSummary* find_cell(const Summary& summary, int condition, std::string_view solver) {
  for (const CellSummary& cell : summary.cells) {
    if (cell.condition == condition && cell.solver == solver) return &cell;
  }
  return nullptr;
}

const CellObservations* find_observations(const Summary& summary, int condition) {
  for (const CellObservations& observations : summary.observations) {
    if (observations.condition == condition) return &observations;
  }
  return nullptr;
}

const CellSummary& cell_at(const Summary& summary, int condition, std::string_view solver) {
  static const CellSummary kNothing;
  const CellSummary* const cell = find_cell(summary, condition, solver);
  return cell == nullptr ? kNothing : *cell;
}

std::vector<const CellSummary*> cells_of(const Summary& summary, std::string_view solver) {
  std::vector<const CellSummary*> cells;
  for (const CellSummary& cell : summary.cells) {
    if (cell.solver == solver) cells.push_back(&cell);
  }
  return cells;
}

int64_t trials_of(const Summary& summary) {
  int64_t trials = 0;
  for (const CellObservations& cell : summary.observations) trials += cell.trials;
  return trials;
}

int conditions_with_trials(const Summary& summary) {
  return static_cast<int>(std::count_if(summary.observations.begin(), summary.observations.end(),
                                        [](const CellObservations& c) { return c.trials > 0; }));
}

double mean_over_conditions(const Summary& summary, std::span<const double> values) {
  double sum = 0;
  int count = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    if (summary.observations[i].trials == 0) continue;
    sum += values[i];
    ++count;
  }
  return count > 0 ? sum / count : kNoNumber;
}

double mean_over_conditions(const Summary& summary, double CellObservations::*member) {
  std::vector<double> values;
  for (const CellObservations& cell : summary.observations) values.push_back(cell.*member);
  return mean_over_conditions(summary, values);
}

double mean_over_conditions(const Summary& summary, std::string_view solver,
                            double CellSummary::*member) {
  std::vector<double> values;
  for (const CellSummary* cell : cells_of(summary, solver)) values.push_back(cell->*member);
  return mean_over_conditions(summary, values);
}

Measured mean_over_conditions(const Summary& summary, std::string_view solver,
                              ErrorSummary CellErrors::*error) {
  double sum = 0, below = 0, above = 0;
  int count = 0;
  for (const CellSummary* cell : cells_of(summary, solver)) {
    if (cell->trials == 0) continue;
    const ErrorSummary& errors = cell->*error;
    sum += errors.mean;
    below += std::pow(errors.mean - errors.mean_ci95[0], 2);
    above += std::pow(errors.mean_ci95[1] - errors.mean, 2);
    ++count;
  }
  if (count == 0) return {};
  const double mean = sum / count;
  return {mean, {mean - std::sqrt(below) / count, mean + std::sqrt(above) / count}};
}

std::string lead_solver(const Study& study) {
  std::string lead;
  for (const TrialSolver& solver : study.solvers()) {
    if (solver.name == "orpe") return "orpe";
    if (lead.empty() && !solver.evaluation_only) lead = solver.name;
  }
  return lead;
}

const PaperFigure* paper_figure(const Condition& condition, std::string_view solver) {
  const auto found = condition.paper.find(std::string(solver));
  return found == condition.paper.end() ? nullptr : &found->second;
}

bool has_paper_figures(const Study& study) {
  return std::any_of(study.conditions.begin(), study.conditions.end(),
                     [](const Condition& condition) { return !condition.paper.empty(); });
}

}  // namespace sightline
