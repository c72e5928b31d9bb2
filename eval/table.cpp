// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace sightline {
namespace {

constexpr size_t kTableWidth = 100;
constexpr size_t kLongestLabel = 30;
constexpr std::string_view kBetweenGroups = "  ";
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

using Texts = std::vector<std::string>;

// ---- Text ----

// Columns on the terminal: UTF-8's continuation bytes take none.
size_t width(std::string_view text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; });
}

std::string padding(const std::string& text, size_t columns) {
  return std::string(columns - std::min(columns, width(text)), ' ');
}

std::string left(const std::string& text, size_t columns) {
  return text + padding(text, columns);
}
std::string right(const std::string& text, size_t columns) {
  return padding(text, columns) + text;
}

std::string shortened(const std::string& text, size_t columns) {
  if (width(text) <= columns) return text;
  std::string kept = text;
  while (width(kept) >= columns) kept.pop_back();
  return kept + "…";
}

std::string without_trailing_spaces(std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  return line;
}

// Breaks at spaces; a word longer than a line is shortened.
std::string wrapped(std::string_view text) {
  std::string lines;
  std::string line;
  while (!text.empty()) {
    const size_t end = std::min(text.find(' '), text.size());
    const std::string word = shortened(std::string(text.substr(0, end)), kTableWidth);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!line.empty() && width(line) + 1 + width(word) > kTableWidth) {
      lines += line + "\n";
      line.clear();
    }
    line += line.empty() ? word : " " + word;
  }
  return lines + line + "\n";
}

std::string number(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-";
}

// Decimals that leave every value of a block at least two digits, within reason.
int decimals_for(const std::vector<double>& values) {
  double least = 1;
  for (const double value : values) {
    if (std::isfinite(value) && value > 0) least = std::min(least, value);
  }
  return std::clamp(static_cast<int>(1 - std::floor(std::log10(least))), 2, 5);
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? kNoNumber : sum / static_cast<double>(values.size());
}

// ---- Blocks: rows with a label, columns in groups ----

struct Column {
  std::string name;
  Texts cells;  // a row each
};

// Columns that belong together and are never torn apart.
struct Group {
  std::string title;
  std::vector<Column> columns;
};

size_t width(const Column& column) {
  size_t widest = width(column.name);
  for (const std::string& cell : column.cells) widest = std::max(widest, width(cell));
  return widest;
}

size_t width(const Group& group) {
  size_t sum = group.columns.size() - 1;
  for (const Column& column : group.columns) sum += width(column);
  return std::max(sum, width(group.title));
}

// One line of a group: `text_of` says what stands in each column.
template <typename TextOf>
std::string group_line(const Group& group, const TextOf& text_of) {
  std::string line;
  for (const Column& column : group.columns) {
    if (!line.empty()) line += ' ';
    line += right(text_of(column), width(column));
  }
  return left(line, width(group));
}

// A block of the groups that fit, taken off the front of `groups`.
std::string block_of_first(const Texts& labels, std::vector<Group>& groups) {
  size_t label_width = 0;
  for (const std::string& label : labels) label_width = std::max(label_width, width(label));

  std::string titles(label_width, ' ');
  std::string names = titles;
  Texts lines;
  for (const std::string& label : labels) lines.push_back(left(label, label_width));
  size_t total = label_width;
  size_t fitting = 0;
  for (const Group& group : groups) {
    total += kBetweenGroups.size() + width(group);
    if (fitting > 0 && total > kTableWidth) break;
    ++fitting;
    titles.append(kBetweenGroups) += left(group.title, width(group));
    names.append(kBetweenGroups) += group_line(group, [](const Column& c) { return c.name; });
    for (size_t row = 0; row < lines.size(); ++row) {
      lines[row].append(kBetweenGroups) +=
          group_line(group, [row](const Column& c) { return c.cells[row]; });
    }
  }
  groups.erase(groups.begin(), groups.begin() + static_cast<std::ptrdiff_t>(fitting));

  std::string block;
  const std::string title_line = without_trailing_spaces(titles);
  if (!title_line.empty()) block += title_line + "\n";
  block += without_trailing_spaces(names) + "\n";
  for (size_t i = 0; i < width(names); ++i) block += "─";
  block += "\n";
  for (const std::string& line : lines) block += without_trailing_spaces(line) + "\n";
  return block;
}

std::string block(const std::string& heading, const Texts& labels, std::vector<Group> groups) {
  std::string text;
  while (!groups.empty()) {
    text += fmt::format("\n{}\n{}", heading, block_of_first(labels, groups));
  }
  return text;
}

// ---- What the study has to say ----

// One of the two errors of the paper, wherever it stands.
struct ErrorKind {
  std::string name;
  ErrorSummary CellSummary::*ours;
  double PaperFigure::*paper;
  int paper_decimals;  // as it prints them
  double CellObservations::*bound;
};

bool has_mean_row(const Study& study) {
  return study.conditions.size() > 1;
}

Texts condition_labels(const Study& study) {
  Texts labels;
  for (const Condition& c : study.conditions) labels.push_back(shortened(c.label, kLongestLabel));
  return labels;
}

Texts row_labels(const Study& study) {
  Texts labels = condition_labels(study);
  if (has_mean_row(study)) labels.push_back("mean");
  return labels;
}

// A solver's cells, by condition.
std::vector<const CellSummary*> cells_of(const Summary& summary, std::string_view solver) {
  std::vector<const CellSummary*> cells;
  for (const CellSummary& cell : summary.cells) {
    if (cell.solver == solver) cells.push_back(&cell);
  }
  return cells;
}

// Values by condition, and their mean below where the table has that row.
Column number_column(const Study& study, const std::string& name, const std::vector<double>& values,
                     int decimals) {
  Column column{name, {}};
  for (const double value : values) column.cells.push_back(number(value, decimals));
  if (has_mean_row(study)) column.cells.push_back(number(mean_of(values), decimals));
  return column;
}

std::vector<double> paper_values(const Study& study, const ErrorKind& kind,
                                 const std::string& solver) {
  std::vector<double> values;
  for (const Condition& condition : study.conditions) {
    const auto figure = condition.paper.find(solver);
    values.push_back(figure != condition.paper.end() ? figure->second.*kind.paper : kNoNumber);
  }
  return values;
}

// The solvers that the paper has figures of: the study's in its order.
Texts paper_solvers(const Study& study) {
  Texts solvers;
  for (const PoseSolver* solver : study.solvers) {
    const std::string name(solver->name);
    const bool is_in_paper =
        std::any_of(study.conditions.begin(), study.conditions.end(),
                    [&](const Condition& condition) { return condition.paper.contains(name); });
    if (is_in_paper) solvers.push_back(name);
  }
  return solvers;
}

Group paper_group(const Study& study, const ErrorKind& kind) {
  Group group{"paper", {}};
  for (const std::string& solver : paper_solvers(study)) {
    group.columns.push_back(
        number_column(study, solver, paper_values(study, kind, solver), kind.paper_decimals));
  }
  return group;
}

Group solver_group(const Study& study, const Summary& summary, const ErrorKind& kind,
                   std::string_view solver, int decimals) {
  std::vector<double> means;
  std::vector<double> medians;
  Column intervals{"95 %", {}};
  for (const CellSummary* cell : cells_of(summary, solver)) {
    const ErrorSummary& error = cell->*kind.ours;
    means.push_back(error.mean);
    medians.push_back(error.median);
    intervals.cells.push_back(fmt::format("[{}, {}]", number(error.mean_ci95[0], decimals),
                                          number(error.mean_ci95[1], decimals)));
  }
  if (has_mean_row(study)) intervals.cells.push_back("");
  Group group{std::string(solver), {number_column(study, "mean", means, decimals), intervals}};
  if (paper_solvers(study).empty()) {
    group.columns.push_back(number_column(study, "median", medians, decimals));
  }
  return group;
}

std::string error_block(const Study& study, const Summary& summary, const ErrorKind& kind) {
  std::vector<double> bounds;
  std::vector<double> all;
  for (const CellObservations& cell : summary.observations) bounds.push_back(cell.*kind.bound);
  for (const CellSummary& cell : summary.cells) all.push_back((cell.*kind.ours).mean);
  const int decimals = decimals_for(all);

  std::vector<Group> groups;
  if (!paper_solvers(study).empty()) groups.push_back(paper_group(study, kind));
  for (const PoseSolver* solver : study.solvers) {
    groups.push_back(solver_group(study, summary, kind, solver->name, decimals));
  }
  groups.push_back({"bound", {number_column(study, "mean", bounds, decimals)}});
  return block(kind.name, row_labels(study), groups);
}

// The cells' mean of a number.
double mean_over(const std::vector<const CellSummary*>& cells, double CellSummary::*member) {
  std::vector<double> values;
  for (const CellSummary* cell : cells) values.push_back(cell->*member);
  return mean_of(values);
}

std::string solver_block(const Study& study, const Summary& summary) {
  Texts labels;
  Column to_oracle{"rms/oracle", {}};
  Column to_bound{"rms/bound", {}};
  Column false_removals{"inliers removed", {}};
  Column missed_outliers{"outliers kept", {}};
  Column exact{"exactly right / %", {}};
  for (const PoseSolver* solver : study.solvers) {
    const auto cells = cells_of(summary, solver->name);
    const auto mean_text = [&cells](double CellSummary::*member) {
      return number(mean_over(cells, member), 2);
    };
    labels.emplace_back(solver->name);
    to_oracle.cells.push_back(mean_text(&CellSummary::ratio_to_oracle));
    to_bound.cells.push_back(mean_text(&CellSummary::ratio_to_bound));
    false_removals.cells.push_back(mean_text(&CellSummary::false_removals));
    missed_outliers.cells.push_back(mean_text(&CellSummary::missed_outliers));
    exact.cells.push_back(number(100 * mean_over(cells, &CellSummary::exact_set_rate), 1));
  }
  const std::string heading = fmt::format("Geodesic error, and removals a trial{}",
                                          has_mean_row(study) ? ", mean over the conditions" : "");
  return block(heading, labels,
               {{"", {to_oracle}},
                {"", {to_bound}},
                {"", {false_removals}},
                {"", {missed_outliers}},
                {"", {exact}}});
}

std::string extraction_block(const Study& study, const Summary& summary) {
  std::vector<double> found, outliers, inlier_rms;
  for (const CellObservations& cell : summary.observations) {
    found.push_back(cell.found);
    outliers.push_back(cell.outliers);
    inlier_rms.push_back(cell.inlier_rms_px);
  }
  const auto features = std::count_if(summary.features.begin(), summary.features.end(),
                                      [](const FeatureSummary& f) { return f.condition == 0; });
  const std::string of_features = fmt::format("found of {}", features);
  return block("Features a trial", row_labels(study),
               {{"", {number_column(study, of_features, found, 2)}},
                {"", {number_column(study, "outliers", outliers, 2)}},
                {"", {number_column(study, "inlier rms / px", inlier_rms, 2)}}});
}

std::string vector_text(const Eigen::Vector3d& v) {
  return fmt::format("({:g}, {:g}, {:g})", v.x(), v.y(), v.z());
}

std::string pose_block(const Study& study) {
  if (study.poses.theta_deg.empty()) return "";
  Column theta{"theta / °", {}};
  Column t{"T / m", {}};
  for (size_t i = 0; i < study.conditions.size(); ++i) {
    theta.cells.push_back(vector_text(study.poses.theta_deg[i]));
    t.cells.push_back(vector_text(study.poses.t_m[i]));
  }
  return block("Poses", condition_labels(study), {{"", {theta}}, {"", {t}}});
}

std::string head(const Study& study, const Summary& summary) {
  int trials = 0;
  for (const CellObservations& cell : summary.observations) trials += cell.trials;
  std::string text = wrapped(study.title.empty() ? study.name : study.title);
  if (!study.reference.empty()) text += wrapped(study.reference);
  return text + wrapped(fmt::format("{} trials in {} condition{}, seed {}", trials,
                                    study.conditions.size(),
                                    study.conditions.size() == 1 ? "" : "s", study.seed));
}

std::string failure_lines(const Study& study, const Summary& summary) {
  std::string lines;
  for (const PoseSolver* solver : study.solvers) {
    int failures = 0;
    int trials = 0;
    for (const CellSummary* cell : cells_of(summary, solver->name)) {
      failures += cell->failures;
      trials += cell->trials;
    }
    if (failures == 0) continue;
    lines += fmt::format("failed: {} {} of {}, counted at the cap of {:g}° and {:g} %\n",
                         solver->name, failures, trials, kAngleCapDeg, kTranslationCapPercent);
  }
  return lines.empty() ? "" : "\n" + lines;
}

}  // namespace

std::string to_table(const Study& study, const Summary& summary) {
  const std::string statistic = "mean of the trials and its 95 % interval";
  const ErrorKind theta{"theta_error / °, " + statistic, &CellSummary::theta_error_deg,
                        &PaperFigure::theta_error_deg, 2, &CellObservations::bound_theta_deg};
  const ErrorKind t{"T_error / % of the distance, " + statistic, &CellSummary::t_error_percent,
                    &PaperFigure::t_error_percent, 1, &CellObservations::bound_t_percent};
  return head(study, summary) + pose_block(study) + error_block(study, summary, theta) +
         error_block(study, summary, t) + solver_block(study, summary) +
         extraction_block(study, summary) + failure_lines(study, summary);
}

}  // namespace sightline
