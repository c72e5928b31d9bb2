// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/tables/extraction_table.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "eval/output/numbers.h"
#include "eval/output/text_table.h"
#include "eval/summary/cells.h"
#include "eval/tables/labels.h"
#include "pose/angles.h"

namespace sightline {
namespace {

std::string percent(double rate) {
  return number_text(100 * rate, 1);
}

TextGroup measured_group(const std::string& title, const std::vector<Localisation>& rows,
                         Measured Localisation::*member, double scale, int decimals) {
  TextColumn values{"value", {}}, intervals{"95 %", {}};
  for (const Localisation& row : rows) {
    const Measured& measured = row.*member;
    values.cells.push_back(number_text(scale * measured.value, decimals));
    intervals.cells.push_back(
        interval_text({scale * measured.ci95[0], scale * measured.ci95[1]}, decimals));
  }
  return {title, {values, intervals}};
}

TextColumn column(const std::string& name, const std::vector<Localisation>& rows,
                  Measured Localisation::*member, int decimals) {
  TextColumn out{name, {}};
  for (const Localisation& row : rows) {
    out.cells.push_back(number_text((row.*member).value, decimals));
  }
  return out;
}

// The labels that occur, right ones first.
std::set<ObservationLabel> labels_in(const std::vector<Localisation>& rows) {
  std::set<ObservationLabel> found;
  for (const Localisation& row : rows) {
    for (const auto& [label, count] : row.labels) found.insert(label);
  }
  return found;
}

TextColumn label_column(ObservationLabel label, const std::vector<Localisation>& rows) {
  TextColumn column{std::string(to_string(label)), {}};
  for (const Localisation& row : rows) {
    int64_t all = 0;
    for (const auto& [other, count] : row.labels) all += count;
    const auto own = row.labels.find(label);
    const double count = own == row.labels.end() ? 0 : static_cast<double>(own->second);
    column.cells.push_back(percent(count / static_cast<double>(all)));
  }
  return column;
}

TextGroup outlier_group(const std::vector<Localisation>& rows) {
  TextColumn sizes{"px: 10, 50, 90 %", {}}, sides{"side / °", {}}, length{"one-sided", {}};
  for (const Localisation& row : rows) {
    const auto& [u, v] = row.outlier_side;
    const bool is_none = std::isnan(row.outlier_px[1]);
    sizes.cells.push_back(is_none ? "-"
                                  : fmt::format("{:.1f}, {:.1f}, {:.1f}", row.outlier_px[0],
                                                row.outlier_px[1], row.outlier_px[2]));
    sides.cells.push_back(is_none ? "-" : number_text(std::atan2(v, u) / kDegree, 0));
    length.cells.push_back(is_none ? "-" : number_text(std::hypot(u, v), 2));
  }
  return {"outliers", {sizes, sides, length}};
}

TextColumn error_column(const std::string& name, const Study& study, const Summary& summary,
                        const std::string& solver) {
  TextColumn column{name, {}};
  for (int c = 0; c < static_cast<int>(study.conditions.size()); ++c) {
    column.cells.push_back(number_text(cell_at(summary, c, solver).geodesic_deg.mean, 3));
  }
  return column;
}

struct LabelledRows {
  std::vector<std::string> labels;
  std::vector<Localisation> rows;
};

// Each feature; each kind, where there are several; all.
LabelledRows rows_of_cell(const PoseStudy& study, const FeatureStatistics& statistics,
                          int condition) {
  LabelledRows out;
  const auto add = [&](const std::string& label, Localisation row) {
    out.labels.push_back(label);
    out.rows.push_back(std::move(row));
  };
  std::set<FeatureKind> kinds;
  for (const int feature : study.features) kinds.insert(study.target->features[feature].kind);
  for (const std::string& feature : statistics.features()) {
    add(feature, statistics.of(condition, feature));
  }
  for (const FeatureKind kind : kinds) {
    if (kinds.size() == 1) break;
    add(fmt::format("every {}", to_string(kind)), statistics.of_kind(condition, kind));
  }
  add("all", statistics.of_cell(condition));
  return out;
}

TextGroup accuracy_group(const std::string& title, const std::vector<Localisation>& rows) {
  TextColumn seen{"to see", {}}, found{"found", {}}, near{"near", {}}, outliers{"out / %", {}},
      median{"median", {}}, rms{"rms", {}};
  for (const Localisation& row : rows) {
    seen.cells.push_back(fmt::to_string(row.visible));
    found.cells.push_back(percent(row.found_rate.value));
    near.cells.push_back(percent(row.near_rate.value));
    outliers.cells.push_back(number_text(100 * row.seen_outlier_rate.value, 2));
    median.cells.push_back(number_text(row.near_median_px, 2));
    rms.cells.push_back(number_text(row.near_rms_px, 2));
  }
  return {title, {seen, found, near, outliers, median, rms}};
}

// Each condition, whatever the feature.
std::vector<Localisation> rows_of_cells(const Study& study, const FeatureStatistics& statistics) {
  std::vector<Localisation> rows;
  for (size_t c = 0; c < study.conditions.size(); ++c) {
    rows.push_back(statistics.of_cell(static_cast<int>(c)));
  }
  return rows;
}

// How few features a trial of each condition has.
std::string fewest_lines(const Study& study, const FeatureStatistics& statistics) {
  const std::vector<std::string> conditions = condition_labels(study);
  std::string text;
  for (size_t c = 0; c < conditions.size(); ++c) {
    const FeatureCounts& counts = statistics.counts(static_cast<int>(c));
    if (counts.trials == 0) continue;
    text += wrapped(fmt::format(
        "{}: at least {} to be seen in every trial, at least {} inliers; fewer than {} inliers in "
        "{} of {} trials",
        conditions[c], counts.fewest_visible, counts.fewest_inliers, kFewFeatures,
        counts.few_inliers, counts.trials));
  }
  return text;
}

}  // namespace

std::string localisation_block(const Study& study, const FeatureStatistics& statistics) {
  const std::vector<Localisation> rows = rows_of_cells(study, statistics);
  return text_block(
      "Features: found of those to be seen, outliers of those found, error of the inliers",
      condition_labels(study),
      {measured_group("found / %", rows, &Localisation::found_rate, 100, 1),
       measured_group("outliers / %", rows, &Localisation::outlier_rate, 100, 1),
       measured_group("rms / px", rows, &Localisation::rms_px, 1, 2),
       {"bias / px",
        {column("u", rows, &Localisation::bias_u_px, 2),
         column("v", rows, &Localisation::bias_v_px, 2)}},
       {"", {column("rms / sigma", rows, &Localisation::rms_sigmas, 2)}}});
}

std::string line_block(const Study& study, const FeatureStatistics& statistics) {
  TextColumn a_trial{"a trial", {}}, right{"right / %", {}}, sigmas{"rms / sigma", {}};
  bool has_lines = false;
  const std::vector<std::string> conditions = condition_labels(study);
  for (size_t c = 0; c < conditions.size(); ++c) {
    const LineCounts& lines = statistics.lines(static_cast<int>(c));
    has_lines = has_lines || lines.lines > 0;
    const auto count = static_cast<double>(lines.lines);
    a_trial.cells.push_back(number_text(count / static_cast<double>(lines.trials), 1));
    right.cells.push_back(percent(static_cast<double>(lines.right) / count));
    sigmas.cells.push_back(number_text(lines.rms_sigmas(), 2));
  }
  if (!has_lines) return "";
  return text_block(
      "Lines along edges: how many, right ones, and the error of these in their sigmas", conditions,
      {{"", {a_trial}}, {"", {right}}, {"", {sigmas}}});
}

std::string accuracy_block(const Study& study, const FeatureStatistics& statistics) {
  constexpr size_t kFewCells = 4;
  const std::vector<std::string> conditions = condition_labels(study);
  const std::string heading = fmt::format(
      "Features to be seen: found, within {} px of the truth, median and rms distance of those",
      kNearPx);
  std::string text;
  if (conditions.size() > kFewCells) {
    text = text_block(heading, conditions, {accuracy_group("", rows_of_cells(study, statistics))});
  } else {
    std::vector<TextGroup> groups;
    std::vector<std::string> labels;
    for (size_t c = 0; c < conditions.size(); ++c) {
      const LabelledRows cell = rows_of_cell(*study.pose_study(), statistics, static_cast<int>(c));
      labels = cell.labels;
      groups.push_back(accuracy_group(conditions[c], cell.rows));
    }
    text = text_block(heading, labels, std::move(groups));
  }
  return text + fewest_lines(study, statistics);
}

std::string failure_block(const FeatureStatistics& statistics) {
  std::vector<Localisation> rows;
  for (const std::string& feature : statistics.features()) {
    rows.push_back(statistics.of_feature(feature));
  }
  std::vector<TextGroup> groups;
  for (const ObservationLabel label : labels_in(rows)) {
    groups.push_back({"", {label_column(label, rows)}});
  }
  groups.push_back(outlier_group(rows));
  return text_block("What became of each feature, % of all trials", statistics.features(), groups);
}

std::string impact_block(const Study& study, const Summary& summary) {
  const std::vector<PoseInput>& inputs = study.pose_study()->solving.inputs;
  if (inputs.empty()) return "";
  std::vector<TextGroup> groups;
  for (const TrialSolver& solver : study.solvers()) {
    if (solver.evaluation_only) continue;
    TextGroup group{std::string(solver.name), {}};
    for (const PoseInput input : inputs) {
      group.columns.push_back(error_column(std::string(to_string(input)), study, summary,
                                           name_with(solver.name, input)));
    }
    group.columns.push_back(error_column("all", study, summary, std::string(solver.name)));
    groups.push_back(std::move(group));
  }
  return text_block(
      "Mean geodesic error / ° of exact projections, of noise alone, of the inliers, of all found",
      condition_labels(study), groups);
}

}  // namespace sightline
