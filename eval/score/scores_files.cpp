// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/scores_files.h"

#include <cmath>
#include <functional>
#include <ostream>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "eval/output/json.h"
#include "eval/output/numbers.h"
#include "eval/output/text_table.h"
#include "eval/score/measures.h"

namespace sightline {
namespace {

// ---- scores.json

Json rate_json(const BopRate& rate) {
  return {{"value", rate.value}, {"ci95", rate.ci95}};
}

Json error_json(const ErrorSummary& error) {
  return {{"mean", error.mean},     {"mean_ci95", error.mean_ci95},
          {"median", error.median}, {"median_ci95", error.median_ci95},
          {"rms", error.rms},       {"rms_ci95", error.rms_ci95}};
}

Json summary_json(const BopSummary& s) {
  Json json = {{"targets", s.targets},
               {"estimated", s.estimated},
               {"ar", rate_json(s.ar)},
               {"ar_mssd", rate_json(s.ar_mssd)},
               {"ar_mspd", rate_json(s.ar_mspd)},
               {"ar_vsd", rate_json(s.ar_vsd)},
               {"mssd_recalls", s.mssd_recalls},
               {"mspd_recalls", s.mspd_recalls}};
  for (const SummaryMeasure& measure : summary_measures()) {
    if (const auto* recall = std::get_if<RecallMeasure>(&measure)) {
      json[std::string(recall->key)] = rate_json(s.*recall->summary);
    } else {
      const auto& error = std::get<ErrorMeasure>(measure);
      json[std::string(error.key)] = error_json(s.*error.summary);
    }
  }
  return json;
}

// ---- errors.csv

// A target and an estimate of it.
struct ErrorsRow {
  const BopPair& pair;
  const BopEstimate& estimate;
  bool is_chosen;
};

struct ErrorsColumn {
  std::string name;
  std::function<std::string(const ErrorsRow&)> text;
};

// Those after the target's own.
std::vector<ErrorsColumn> errors_columns() {
  std::vector<ErrorsColumn> columns = {
      {"line", [](const ErrorsRow& row) { return fmt::format("{}", row.estimate.line); }},
      {"score", [](const ErrorsRow& row) { return fmt::format("{}", row.estimate.score); }},
      {"is_chosen", [](const ErrorsRow& row) { return fmt::format("{:d}", row.is_chosen); }}};
  for (const PairMeasure& measure : pair_measures()) {
    columns.push_back({std::string(measure.column), [&measure](const ErrorsRow& row) {
                         const double number = row.pair.*measure.number;
                         return std::isnan(number) ? "" : fmt::format("{}", number);
                       }});
  }
  for (int tau = 0; tau < kBopThresholds; ++tau) {
    columns.push_back({fmt::format("vsd_{:.2f}", bop_fraction(tau)), [tau](const ErrorsRow& row) {
                         return row.pair.vsd.empty() ? "" : fmt::format("{}", row.pair.vsd[tau]);
                       }});
  }
  return columns;
}

// ---- the table

TextGroup rate_group(const std::string& name, const std::vector<BopRate>& rates) {
  TextGroup group{name, {{"", {}}, {"95 %", {}}}};
  for (const BopRate& rate : rates) {
    group.columns[0].cells.push_back(number_text(rate.value, 4));
    group.columns[1].cells.push_back(
        fmt::format("[{}, {}]", number_text(rate.ci95[0], 4), number_text(rate.ci95[1], 4)));
  }
  return group;
}

// The rows of the table: their labels and what they tell of.
struct SummaryRows {
  std::vector<std::string> labels;
  std::vector<BopSummary> summaries;
};

// `method` stands before each label; empty of a single one.
void add_rows(const BopScores& scores, const std::string& method, SummaryRows& rows) {
  const auto add = [&](const std::string& label, BopSummary summary) {
    rows.labels.push_back(method.empty() ? label : fmt::format("{}, {}", method, label));
    rows.summaries.push_back(std::move(summary));
  };
  add("all", summarise(scores));
  const auto by_object = summarise_by_object(scores);
  if (by_object.size() < 2) return;
  for (const auto& [obj_id, summary] : by_object) add(fmt::format("object {}", obj_id), summary);
}

SummaryRows summary_rows(std::span<const MethodScores> methods) {
  SummaryRows rows;
  for (const MethodScores& method : methods) {
    add_rows(method.scored.scores, methods.size() > 1 ? method.name : "", rows);
  }
  return rows;
}

std::vector<TextGroup> recall_groups(const SummaryRows& rows) {
  std::vector<std::pair<std::string, BopRate BopSummary::*>> rates = {
      {"AR", &BopSummary::ar},
      {"AR_MSSD", &BopSummary::ar_mssd},
      {"AR_MSPD", &BopSummary::ar_mspd},
      {"AR_VSD", &BopSummary::ar_vsd}};
  for (const SummaryMeasure& measure : summary_measures()) {
    if (const auto* recall = std::get_if<RecallMeasure>(&measure)) {
      rates.emplace_back(recall->text_label, recall->summary);
    }
  }
  std::vector<TextGroup> groups;
  for (const auto& [name, member] : rates) {
    std::vector<BopRate> column;
    for (const BopSummary& summary : rows.summaries) column.push_back(summary.*member);
    groups.push_back(rate_group(name, column));
  }
  return groups;
}

TextGroup count_group(const std::string& label, const SummaryRows& rows,
                      int64_t BopSummary::*count) {
  TextColumn column{label, {}};
  for (const BopSummary& summary : rows.summaries) {
    column.cells.push_back(fmt::to_string(summary.*count));
  }
  return {"", {column}};
}

// The errors that are told so, in a group each.
std::vector<TextGroup> error_groups(const SummaryRows& rows, Told told) {
  std::vector<TextGroup> groups;
  for (const SummaryMeasure& measure : summary_measures()) {
    const auto* error = std::get_if<ErrorMeasure>(&measure);
    if (error == nullptr || error->told != told) continue;
    TextColumn column{std::string(error->text_label), {}};
    for (const BopSummary& summary : rows.summaries) {
      const ErrorSummary& errors = summary.*error->summary;
      column.cells.push_back(number_text(told == Told::kMedian ? errors.median : errors.mean, 4));
    }
    groups.push_back({"", {column}});
  }
  return groups;
}

}  // namespace

std::string scores_json(const ScoredResults& scored) {
  Json objects = Json::array();
  for (const auto& [obj_id, summary] : summarise_by_object(scored.scores)) {
    Json object = {{"obj_id", obj_id}};
    object.update(summary_json(summary));
    objects.push_back(std::move(object));
  }
  const Json json = {{"version", SIGHTLINE_VERSION},
                     {"results", scored.results},
                     {"dataset", scored.set},
                     {"vsd_delta_mm", scored.vsd_delta_mm},
                     {"estimates", scored.estimates.size()},
                     {"ignored_estimates", scored.scores.ignored_estimates},
                     {"all", summary_json(summarise(scored.scores))},
                     {"objects", objects}};
  return json_text(json);
}

std::string scores_json(std::span<const MethodScores> methods) {
  const ScoredResults& first = methods.front().scored;
  Json json = {{"version", SIGHTLINE_VERSION},
               {"dataset", first.set},
               {"vsd_delta_mm", first.vsd_delta_mm},
               {"methods", Json::array()}};
  for (const MethodScores& method : methods) {
    Json scores = {{"name", method.name}};
    scores.update(Json::parse(scores_json(method.scored)));
    json["methods"].push_back(std::move(scores));
  }
  return json_text(json);
}

void write_errors_csv(const ScoredResults& scored, std::ostream& out) {
  const std::vector<ErrorsColumn> columns = errors_columns();
  out << "scene_id,im_id,obj_id,gt_id";
  for (const ErrorsColumn& column : columns) out << "," << column.name;
  out << "\n";
  for (const BopTarget& target : scored.scores.targets) {
    const BopImage& image = scored.dataset.images[target.image];
    const std::string key =
        fmt::format("{},{},{},{}", image.scene_id, image.im_id, target.obj_id, target.instance);
    if (target.pairs.empty()) out << key << std::string(columns.size(), ',') << "\n";
    for (size_t i = 0; i < target.pairs.size(); ++i) {
      const BopPair& pair = target.pairs[i];
      const ErrorsRow row{pair, scored.estimates[pair.estimate], target.chosen == i};
      out << key;
      for (const ErrorsColumn& column : columns) out << "," << column.text(row);
      out << "\n";
    }
  }
}

std::string score_table(std::span<const MethodScores> methods) {
  const SummaryRows rows = summary_rows(methods);
  std::vector<TextGroup> medians = {count_group("targets", rows, &BopSummary::targets),
                                    count_group("estimated", rows, &BopSummary::estimated)};
  for (TextGroup& group : error_groups(rows, Told::kMedian)) medians.push_back(std::move(group));
  return text_block("Recall, and its 95 % interval", rows.labels, recall_groups(rows)) +
         text_block("Medians of the targets, a missed one counting as infinite", rows.labels,
                    medians) +
         text_block(
             fmt::format("Mean scores of ESA's challenges, a missed target counting as {:.4f}",
                         kSpeedScoreCap),
             rows.labels, error_groups(rows, Told::kMean));
}

}  // namespace sightline
