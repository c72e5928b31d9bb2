// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/means.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sightline {
namespace {

MeanInterval mean_of(const std::vector<MeanInterval>& strata) {
  if (strata.empty()) return {};
  MeanInterval all{0, {}};
  double below = 0;
  double above = 0;
  for (const MeanInterval& stratum : strata) {
    all.mean += stratum.mean;
    below += std::pow(stratum.mean - stratum.ci95[0], 2);
    above += std::pow(stratum.ci95[1] - stratum.mean, 2);
  }
  const double n = static_cast<double>(strata.size());
  all.mean /= n;
  all.ci95 = {all.mean - std::sqrt(below) / n, all.mean + std::sqrt(above) / n};
  return all;
}

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

std::string lead_solver(const Study& study) {
  std::string lead;
  for (const PoseSolver* solver : study.solvers()) {
    if (solver->name == "orpe") return "orpe";
    if (lead.empty() && !solver->evaluation_only) lead = solver->name;
  }
  return lead;
}

SolverMeans means_over_conditions(const Study& study, const Summary& summary,
                                  std::string_view solver) {
  SolverMeans means;
  means.solver = solver;
  std::vector<MeanInterval> thetas;
  std::vector<MeanInterval> ts;
  std::vector<int> conditions;
  for (const CellSummary& cell : summary.cells) {
    if (cell.solver != solver || cell.trials == 0) continue;
    conditions.push_back(cell.condition);
    means.trials += cell.trials;
    means.failures += cell.failures;
    thetas.push_back({cell.theta_error_deg.mean, cell.theta_error_deg.mean_ci95});
    ts.push_back({cell.t_error_percent.mean, cell.t_error_percent.mean_ci95});
  }
  means.theta_error_deg = mean_of(thetas);
  means.t_error_percent = mean_of(ts);
  means.paper = mean_paper_figure(study, conditions, solver);
  return means;
}

const PaperFigure* paper_figure(const Condition& condition, std::string_view solver) {
  const auto found = condition.paper.find(std::string(solver));
  return found == condition.paper.end() ? nullptr : &found->second;
}

bool has_paper_figures(const Study& study) {
  return std::any_of(study.conditions.begin(), study.conditions.end(),
                     [](const Condition& condition) { return !condition.paper.empty(); });
}

double mean_over_conditions(const Summary& summary, double CellObservations::*member) {
  double sum = 0;
  for (const CellObservations& cell : summary.observations) {
    if (cell.trials > 0) sum += cell.*member;
  }
  const int conditions = conditions_with_trials(summary);
  return conditions > 0 ? sum / conditions : ErrorSummary::kNone;
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

}  // namespace sightline
