// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/tables/result_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/numbers.h"
#include "eval/output/text_table.h"
#include "eval/summary/cells.h"
#include "eval/summary/claims.h"
#include "eval/summary/quantities.h"
#include "eval/tables/extraction_table.h"
#include "eval/tables/labels.h"
#include "eval/tables/sweep_table.h"

namespace sightline {
namespace {

using Texts = std::vector<std::string>;

// Decimals that leave every value of a block at least two digits, within reason.
int decimals_for(const std::vector<double>& values) {
  double least = 1;
  for (const double value : values) {
    if (std::isfinite(value) && value > 0) least = std::min(least, value);
  }
  return std::clamp(static_cast<int>(1 - std::floor(std::log10(least))), 2, 5);
}

bool has_mean_row(const Study& study) {
  return study.conditions.size() > 1;
}

Texts row_labels(const Study& study) {
  Texts labels = condition_labels(study);
  if (has_mean_row(study)) labels.push_back("mean");
  return labels;
}

// Values by condition, and their mean below where the table has that row.
TextColumn number_column(const Study& study, const Summary& summary, const std::string& name,
                         const std::vector<double>& values, int decimals) {
  TextColumn column{name, {}};
  for (const double value : values) column.cells.push_back(number_text(value, decimals));
  if (has_mean_row(study))
    column.cells.push_back(number_text(mean_over_conditions(summary, values), decimals));
  return column;
}

std::vector<double> paper_values(const Study& study, const Quantity& error,
                                 const std::string& solver) {
  std::vector<double> values;
  for (const Condition& condition : study.conditions) {
    const PaperFigure* const figure = paper_figure(condition, solver);
    values.push_back(figure != nullptr ? figure->*error.paper : kNoNumber);
  }
  return values;
}

// The solvers that the paper has figures of: the study's in its order.
Texts paper_solvers(const Study& study) {
  Texts solvers;
  for (const TrialSolver& solver : study.solvers()) {
    const std::string name(solver.name);
    const bool is_in_paper = std::any_of(
        study.conditions.begin(), study.conditions.end(),
        [&](const Condition& condition) { return paper_figure(condition, name) != nullptr; });
    if (is_in_paper) solvers.push_back(name);
  }
  return solvers;
}

TextGroup paper_group(const Study& study, const Summary& summary, const Quantity& error) {
  TextGroup group{"paper", {}};
  for (const std::string& solver : paper_solvers(study)) {
    group.columns.push_back(number_column(
        study, summary, solver, paper_values(study, error, solver), error.paper_decimals));
  }
  return group;
}

TextGroup solver_group(const Study& study, const Summary& summary, const Quantity& error,
                       std::string_view solver, int decimals) {
  std::vector<double> means;
  std::vector<double> medians;
  TextColumn intervals{"95 %", {}};
  for (const CellSummary* cell : cells_of(summary, solver)) {
    const ErrorSummary& summarised = cell->*error.summary;
    means.push_back(summarised.mean);
    medians.push_back(summarised.median);
    intervals.cells.push_back(interval_text(summarised.mean_ci95, decimals));
  }
  if (has_mean_row(study)) intervals.cells.push_back("");
  TextGroup group{std::string(solver),
                  {number_column(study, summary, "mean", means, decimals), intervals}};
  if (paper_solvers(study).empty()) {
    group.columns.push_back(number_column(study, summary, "median", medians, decimals));
  }
  return group;
}

std::string error_block(const Study& study, const Summary& summary, const Quantity& error) {
  std::vector<double> bounds;
  std::vector<double> all;
  for (const CellObservations& cell : summary.observations) bounds.push_back(cell.*error.bound);
  for (const CellSummary& cell : summary.cells) all.push_back((cell.*error.summary).mean);
  const int decimals = decimals_for(all);

  std::vector<TextGroup> groups;
  if (!paper_solvers(study).empty()) groups.push_back(paper_group(study, summary, error));
  for (const TrialSolver& solver : study.solvers()) {
    groups.push_back(solver_group(study, summary, error, solver.name, decimals));
  }
  groups.push_back({"bound", {number_column(study, summary, "mean", bounds, decimals)}});
  return text_block(fmt::format("{} and its 95 % interval", error.in_pose_studies.heading),
                    row_labels(study), groups);
}

std::string solver_block(const Study& study, const Summary& summary) {
  Texts labels;
  TextColumn to_oracle{"rms/oracle", {}};
  TextColumn to_bound{"rms/bound", {}};
  TextColumn false_removals{"inliers removed", {}};
  TextColumn missed_outliers{"outliers kept", {}};
  TextColumn exact{"exactly right / %", {}};
  for (const TrialSolver& solver : study.solvers()) {
    const auto mean_text = [&](double CellSummary::*member) {
      return number_text(mean_over_conditions(summary, solver.name, member), 2);
    };
    labels.emplace_back(solver.name);
    to_oracle.cells.push_back(mean_text(&CellSummary::ratio_to_oracle));
    to_bound.cells.push_back(mean_text(&CellSummary::ratio_to_bound));
    false_removals.cells.push_back(mean_text(&CellSummary::false_removals));
    missed_outliers.cells.push_back(mean_text(&CellSummary::missed_outliers));
    exact.cells.push_back(number_text(
        100 * mean_over_conditions(summary, solver.name, &CellSummary::exact_set_rate), 1));
  }
  const std::string heading = fmt::format("Geodesic error, and removals a trial{}",
                                          has_mean_row(study) ? ", mean over the conditions" : "");
  return text_block(heading, labels,
                    {{"", {to_oracle}},
                     {"", {to_bound}},
                     {"", {false_removals}},
                     {"", {missed_outliers}},
                     {"", {exact}}});
}

// By how much errors grow from what the image says to what the solvers make of it.
std::string ladder_block(const Summary& summary) {
  if (summary.ladder.empty()) return "";
  Texts labels;
  TextColumn trials{"trials", {}};
  TextGroup angle{"geodesic angle", {{"factor", {}}, {"95 %", {}}}};
  TextGroup translation{"translation", angle.columns};
  const auto add = [](const Measured& factor, TextGroup& group) {
    group.columns[0].cells.push_back(number_text(factor.value, 2));
    group.columns[1].cells.push_back(interval_text(factor.ci95, 2));
  };
  for (const LadderStep& step : summary.ladder) {
    labels.push_back(fmt::format("{} to {}", step.from, step.to));
    trials.cells.push_back(fmt::to_string(step.trials));
    add(step.geodesic, angle);
    add(step.translation, translation);
  }
  return text_block("From the image to the pose: by how much errors grow, geometric means", labels,
                    {{"", {trials}}, angle, translation});
}

std::string extraction_block(const Study& study, const Summary& summary) {
  std::vector<double> found, outliers, inlier_rms;
  for (const CellObservations& cell : summary.observations) {
    found.push_back(cell.found);
    outliers.push_back(cell.outliers);
    inlier_rms.push_back(cell.inlier_rms_px);
  }
  const std::string of_features = fmt::format("found of {}", study.pose_study()->features.size());
  return text_block("Features a trial", row_labels(study),
                    {{"", {number_column(study, summary, of_features, found, 2)}},
                     {"", {number_column(study, summary, "outliers", outliers, 2)}},
                     {"", {number_column(study, summary, "inlier rms / px", inlier_rms, 2)}}});
}

std::string vector_text(const Eigen::Vector3d& v) {
  return fmt::format("({:g}, {:g}, {:g})", v.x(), v.y(), v.z());
}

std::string pose_block(const Study& study) {
  const ImageStudy& images = *study.images();
  const PoseLaw& poses = images.pose_law();
  if (poses.theta_deg.empty()) return "";
  TextColumn theta{"theta / °", {}};
  TextColumn t{"T / m", {}};
  for (const ImageCell& cell : images.cells) {
    theta.cells.push_back(vector_text(poses.theta_deg[cell.pose]));
    t.cells.push_back(vector_text(poses.t_m[cell.pose]));
  }
  return text_block("Poses", condition_labels(study), {{"", {theta}}, {"", {t}}});
}

std::string head(const Study& study, const Summary& summary) {
  const int64_t trials = trials_of(summary);
  std::string text = wrapped(study.title.empty() ? study.name : study.title);
  if (!study.reference.empty()) text += wrapped(study.reference);
  if (!study.claim.empty()) text += wrapped(fmt::format("The paper: {}", study.claim));
  const std::vector<std::string> verdicts = claim_verdicts(study, summary);
  if (!verdicts.empty()) text += wrapped(fmt::format("Here: {}", fmt::join(verdicts, " ")));
  const size_t all = study.conditions.size();
  const auto run = static_cast<size_t>(conditions_with_trials(summary));
  const std::string conditions =
      run == all ? fmt::format("{}", all) : fmt::format("{} of {}", run, all);
  const std::string of_all =
      trials == study.trial_count() ? "" : fmt::format(" of {}", study.trial_count());
  return text + wrapped(fmt::format("{}{} trials in {} condition{}, seed {}", trials, of_all,
                                    conditions, all == 1 ? "" : "s", study.seed));
}

// What a study adds that varies nuisances or takes errors apart.
std::string sweep_of_nuisances(const Study& study, const Summary& summary) {
  const ImageStudy& images = *study.images();
  const bool is_wanted = images.setups.size() > 1 || !images.solving.inputs.empty();
  if (!is_wanted || !summary.extraction) return "";
  return localisation_block(study, *summary.extraction) + line_block(study, *summary.extraction) +
         accuracy_block(study, *summary.extraction) + failure_block(*summary.extraction) +
         impact_block(study, summary);
}

// Where the oracle fails now and then, which counts as the cap, its mean says little beside
// others': the means of all solvers over the trials in which it has a pose.
std::string beside_oracle(const Study& study, const Summary& summary) {
  int failures = 0;
  int trials = 0;
  for (const CellSummary* cell : cells_of(summary, "oracle")) {
    failures += cell->failures;
    trials += cell->oracle_trials;
  }
  if (failures == 0 || trials == 0) return "";
  Texts means;
  for (const std::string& solver : study.solver_names()) {
    double theta = 0;
    double t = 0;
    for (const CellSummary* cell : cells_of(summary, solver)) {
      if (cell->oracle_trials == 0) continue;
      theta += cell->theta_beside_oracle_deg * cell->oracle_trials;
      t += cell->t_beside_oracle_percent * cell->oracle_trials;
    }
    means.push_back(fmt::format("{} {}, {}", solver, number_text(theta / trials, 2),
                                number_text(t / trials, 3)));
  }
  return fmt::format(
      "\n{}", wrapped(fmt::format(
                  "The oracle has no pose in {} trials: fewer than three points are right. In the "
                  "other {} the mean theta_error / ° and T_error / % are: {}.",
                  failures, trials, fmt::join(means, "; "))));
}

// Why there are no intervals of theta_error's means.
std::string lock_line(const Summary& summary) {
  const bool is_near =
      std::any_of(summary.cells.begin(), summary.cells.end(), [](const CellSummary& cell) {
        const ErrorSummary& theta = cell.theta_error_deg;
        return cell.trials > 1 && std::isfinite(theta.mean) && std::isnan(theta.mean_ci95[0]);
      });
  if (!is_near) return "";
  return fmt::format(
      "\n{}",
      wrapped("theta_error's means have no interval where attitudes come near gimbal lock (yaw "
              "beyond 60 degrees): none would hold. Judge by the geodesic angle."));
}

std::string failure_lines(const Study& study, const Summary& summary) {
  std::string lines;
  for (const std::string& solver : study.solver_names()) {
    int failures = 0;
    int trials = 0;
    for (const CellSummary* cell : cells_of(summary, solver)) {
      failures += cell->failures;
      trials += cell->trials;
    }
    if (failures == 0) continue;
    lines += fmt::format("failed: {} {} of {}, counted at the cap of {:g}° and {:g} %\n", solver,
                         failures, trials, kAngleCapDeg, kTranslationCapPercent);
  }
  return lines.empty() ? "" : "\n" + lines;
}

}  // namespace

std::string repeat_warning(const Summary& summary) {
  int repeated = 0;
  for (const CellObservations& cell : summary.observations) repeated += cell.repeated;
  if (repeated == 0) return "";
  return fmt::format(
      "{} of {} trials are an earlier one again, to the last bit: they make the intervals narrow "
      "and tell nothing (is a seed ignored?)",
      repeated, trials_of(summary));
}

std::string to_table(const Study& study, const Summary& summary) {
  const std::string repeats = repeat_warning(summary);
  const std::string warning =
      repeats.empty() ? "" : fmt::format("\n{}", wrapped("warning: " + repeats));
  if (study.images() == nullptr) {
    return head(study, summary) + beside_oracle(study, summary) + sweep_blocks(study, summary) +
           lock_line(summary) + failure_lines(study, summary) + warning;
  }
  std::string text = head(study, summary) + pose_block(study) + beside_oracle(study, summary);
  for (const Quantity& error : quantities()) {
    if (error.paper != nullptr) text += error_block(study, summary, error);
  }
  return text + solver_block(study, summary) + ladder_block(summary) +
         extraction_block(study, summary) + sweep_of_nuisances(study, summary) +
         lock_line(summary) + failure_lines(study, summary) + warning;
}

}  // namespace sightline
