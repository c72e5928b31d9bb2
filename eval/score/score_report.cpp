// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/score_report.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <kainjow/mustache.hpp>

#include "eval/output/html.h"
#include "eval/output/numbers.h"
#include "eval/records/caps.h"
#include "eval/report/distributions.h"
#include "eval/report/page.h"
#include "eval/report/page_text.h"
#include "eval/score/measures.h"
#include "eval/score/score_pictures.h"
#include "eval/statistics/rate_interval.h"

namespace sightline {
namespace {

namespace mustache = kainjow::mustache;

constexpr size_t kMostObjects = 12;  // with curves of their own
constexpr size_t kMostWorst = 30;
constexpr size_t kMostPictures = 12;  // of them

// One of our own errors, of the pair that counts.
struct PairError {
  std::string id;
  std::string label;
  double cap = 0;
  double (*of)(const BopPair& pair, const BopModel& model);
};

std::vector<PairError> pair_errors(bool has_models) {
  std::vector<PairError> errors = {
      {"theta", "θ error, °", kAngleCapDeg,
       [](const BopPair& p, const BopModel&) { return p.theta_error_deg; }},
      {"t", "T error, %", kTranslationCapPercent,
       [](const BopPair& p, const BopModel&) { return p.t_error_percent; }},
      {"geodesic", "Geodesic error, °", kAngleCapDeg,
       [](const BopPair& p, const BopModel&) { return p.geodesic_deg; }}};
  if (!has_models) return errors;
  errors.push_back({"mssd", "MSSD, % of the diameter", 50, [](const BopPair& p, const BopModel& m) {
                      return 100 * p.mssd_mm / m.diameter_mm;
                    }});
  errors.push_back({"mspd", "MSPD, px of the image", 50,
                    [](const BopPair& p, const BopModel&) { return p.mspd_px; }});
  return errors;
}

const BopPair* chosen_of(const BopTarget& target) {
  return target.chosen ? &target.pairs[*target.chosen] : nullptr;
}

std::string object_name(int obj_id) {
  return fmt::format("object {}", obj_id);
}

// All instances, then each object's where there are several.
std::vector<std::pair<std::string, BopSummary>> summaries_of(const BopScores& scores) {
  std::vector<std::pair<std::string, BopSummary>> summaries = {{"all", summarise(scores)}};
  const auto by_object = summarise_by_object(scores);
  if (by_object.size() < 2) return summaries;
  for (const auto& [obj_id, summary] : by_object) {
    summaries.emplace_back(object_name(obj_id), summary);
  }
  return summaries;
}

// ---- charts

ChartSeries recall_series(const std::string& label, int style,
                          const std::array<double, kBopThresholds>& recalls, double (*x)(int),
                          int64_t targets) {
  ChartSeries series{.label = label, .style = style};
  for (int i = 0; i < kBopThresholds; ++i) {
    const auto good = std::llround(recalls[i] * static_cast<double>(targets));
    const Interval95 ci95 = rate_interval(good, targets);
    series.x.push_back(x(i));
    series.y.push_back(100 * recalls[i]);
    series.low.push_back(100 * ci95[0]);
    series.high.push_back(100 * ci95[1]);
    series.count.push_back(static_cast<double>(targets));
  }
  return series;
}

using Recalls = std::array<double, kBopThresholds> BopSummary::*;

Chart recall_chart(const ScoredResults& input, const std::string& id, const std::string& error,
                   const std::string& unit, Recalls recalls, double (*x)(int)) {
  Chart chart;
  chart.id = chart.group = "recall-" + id;
  chart.title = fmt::format("Instances found, by the {} allowed", error);
  chart.note = "Bands: 95 % of the rate (modified Wilson). The mean over the thresholds is AR_" +
               error + ".";
  chart.x.label = fmt::format("{} allowed, {}", error, unit);
  chart.y = {.label = "recall, %", .low = 0, .high = 100};
  const auto summaries = summaries_of(input.scores);
  for (size_t i = 0; i < std::min(summaries.size(), kMostObjects + 1); ++i) {
    const auto& [name, summary] = summaries[i];
    chart.series.push_back(
        recall_series(name, static_cast<int>(i), summary.*recalls, x, summary.targets));
  }
  return chart;
}

std::vector<Chart> recall_charts(const ScoredResults& input) {
  if (!input.scores.has_models) return {};
  const auto percent = [](int i) { return 100 * bop_fraction(i); };
  return {
      recall_chart(input, "mssd", "MSSD", "% of the diameter", &BopSummary::mssd_recalls, percent),
      recall_chart(input, "mspd", "MSPD", "px at a width of 640", &BopSummary::mspd_recalls,
                   bop_pixels)};
}

std::vector<ErrorSample> samples_of(const ScoredResults& input, const PairError& error) {
  std::vector<ErrorSample> samples = {{"all", 0, {}}};
  std::map<int, std::vector<double>> by_object;
  for (const BopTarget& target : input.scores.targets) {
    const BopPair* pair = chosen_of(target);
    const double value = pair == nullptr ? std::numeric_limits<double>::infinity()
                                         : error.of(*pair, input.dataset.models.at(target.obj_id));
    samples.front().errors.push_back(value);
    by_object[target.obj_id].push_back(value);
  }
  if (by_object.size() < 2) return samples;
  for (const auto& [obj_id, errors] : by_object) {
    if (samples.size() > kMostObjects) break;
    samples.push_back({object_name(obj_id), static_cast<int>(samples.size()), errors});
  }
  return samples;
}

std::vector<Chart> error_charts(const ScoredResults& input, const std::string& group,
                                DistributionChart chart_of) {
  std::vector<Chart> charts;
  for (const PairError& error : pair_errors(input.scores.has_models)) {
    Chart chart = chart_of(error.label, error.cap, samples_of(input, error));
    chart.group = group;
    chart.id = fmt::format("{}-{}", group, error.id);
    chart.option = error.label;
    charts.push_back(std::move(chart));
  }
  return charts;
}

// ---- text

mustache::object rate_cell(const BopRate& rate) {
  return {{"value", fixed(rate.value, 3)}, {"interval", interval(rate.ci95, 3)}};
}

mustache::object median_cell(const ErrorSummary& error) {
  return {{"value", measure(error.median)},
          {"interval", interval(error.median_ci95, decimals_for(error.median))}};
}

mustache::object named(std::string name, mustache::object cell, const std::string& unit = "") {
  cell["name"] = std::move(name);
  if (!unit.empty()) cell["value"] = cell["value"].string_value() + unit;
  return cell;
}

std::string lead(const BopSummary& all, const BopScores& scores) {
  if (all.targets == 0) return "The data set asks for no instance.";
  if (!scores.has_models) {
    return fmt::format("Mean SPEED score: {} {}. Without a model there are errors of poses alone.",
                       fixed(all.speed_score.mean, 4), interval(all.speed_score.mean_ci95, 4));
  }
  const bool has_vsd = all.ar.value == all.ar.value;
  const BopRate& rate = has_vsd ? all.ar : all.ar_mssd;
  return fmt::format("{}: {} {}.{}", has_vsd ? "Average recall" : "Average recall of MSSD",
                     fixed(rate.value, 3), interval(rate.ci95, 3),
                     has_vsd             ? ""
                     : !scores.has_faces ? " A model without faces has no VSD, and so no AR."
                                         : " Images without depth have no VSD, and so no AR.");
}

std::string counts(const ScoredResults& input, const BopSummary& all) {
  std::string text = fmt::format("{} of {} are missed: they have no estimate.",
                                 all.targets - all.estimated, counted(all.targets, "instance"));
  if (input.scores.ignored_estimates > 0) {
    text += fmt::format(" {} of {} are of nothing that is asked for, or more than are.",
                        input.scores.ignored_estimates,
                        counted(static_cast<int64_t>(input.estimates.size()), "estimate"));
  }
  return text;
}

std::string answer_html(const ScoredResults& input) {
  const BopSummary all = summarise(input.scores);
  mustache::data findings(mustache::data::type::list);
  findings << named("AR_MSSD", rate_cell(all.ar_mssd)) << named("AR_MSPD", rate_cell(all.ar_mspd));
  if (input.scores.has_vsd) findings << named("AR_VSD", rate_cell(all.ar_vsd));
  findings << named("ADD below a tenth of the diameter", rate_cell(all.add))
           << named("median θ error", median_cell(all.theta_error_deg), "°")
           << named("median T error", median_cell(all.t_error_percent), " %")
           << named("median geodesic error", median_cell(all.geodesic_deg), "°");
  return mustache::mustache(page_text("score_answer.mustache"))
      .render(mustache::object{{"results", input.results},
                               {"lead", lead(all, input.scores)},
                               {"findings", findings},
                               {"counts", counts(input, all)}});
}

std::string table_html(const std::string& label, const std::string& caption,
                       const std::vector<std::string>& columns, mustache::data rows) {
  mustache::data names(mustache::data::type::list);
  for (const std::string& column : columns) names << column;
  return mustache::mustache(page_text("score_table.mustache"))
      .render(mustache::object{
          {"label", label}, {"caption", caption}, {"columns", names}, {"rows", std::move(rows)}});
}

// A column of the table of scores: its head, and the cell of a row.
struct ScoreColumn {
  std::string head;
  std::function<mustache::object(const BopSummary&)> cell;
};

mustache::object count_cell(int64_t count) {
  return {{"value", fmt::to_string(count)}, {"interval", ""}};
}

std::vector<ScoreColumn> average_recall_columns() {
  return {{"AR", [](const BopSummary& s) { return rate_cell(s.ar); }},
          {"AR_MSSD", [](const BopSummary& s) { return rate_cell(s.ar_mssd); }},
          {"AR_MSPD", [](const BopSummary& s) { return rate_cell(s.ar_mspd); }},
          {"AR_VSD", [](const BopSummary& s) { return rate_cell(s.ar_vsd); }}};
}

ScoreColumn error_column(const ErrorMeasure& error) {
  return {std::string(error.page_label), [error](const BopSummary& s) {
            const ErrorSummary& summary = s.*error.summary;
            return error.told == Told::kMedian ? median_cell(summary)
                                               : rate_cell({summary.mean, summary.mean_ci95});
          }};
}

// Counts, recalls, medians, means.
std::vector<ScoreColumn> score_columns() {
  std::vector<ScoreColumn> columns = {
      {"instances", [](const BopSummary& s) { return count_cell(s.targets); }},
      {"missed", [](const BopSummary& s) { return count_cell(s.targets - s.estimated); }}};
  for (ScoreColumn& column : average_recall_columns()) columns.push_back(std::move(column));
  for (const SummaryMeasure& measure : summary_measures()) {
    const auto* recall = std::get_if<RecallMeasure>(&measure);
    if (recall == nullptr) continue;
    columns.push_back(
        {std::string(recall->page_label),
         [rate = recall->summary](const BopSummary& s) { return rate_cell(s.*rate); }});
  }
  for (const Told told : {Told::kMedian, Told::kMean}) {
    for (const SummaryMeasure& measure : summary_measures()) {
      const auto* error = std::get_if<ErrorMeasure>(&measure);
      if (error != nullptr && error->told == told) columns.push_back(error_column(*error));
    }
  }
  return columns;
}

std::string objects_html(const ScoredResults& input) {
  const std::vector<ScoreColumn> columns = score_columns();
  std::vector<std::string> heads = {""};
  for (const ScoreColumn& column : columns) heads.push_back(column.head);
  mustache::data rows(mustache::data::type::list);
  for (const auto& [name, summary] : summaries_of(input.scores)) {
    mustache::data cells(mustache::data::type::list);
    for (const ScoreColumn& column : columns) cells << column.cell(summary);
    rows << mustache::object{{"head", name}, {"cells", cells}};
  }
  return table_html(
      "Scores",
      "Recalls, medians of our own errors in which a missed instance counts as infinite, "
      "and mean scores of SPEED and SPEED+, with 95 % intervals in brackets.",
      heads, std::move(rows));
}

// From the worst on; a missed instance has nothing to look at.
std::vector<const BopTarget*> worst_of(const ScoredResults& input) {
  std::vector<const BopTarget*> worst;
  for (const BopTarget& target : input.scores.targets) {
    if (target.chosen) worst.push_back(&target);
  }
  const auto relative = [&](const BopTarget* target) {
    if (!input.scores.has_models) return chosen_of(*target)->t_error_percent;
    return chosen_of(*target)->mssd_mm / input.dataset.models.at(target->obj_id).diameter_mm;
  };
  std::stable_sort(worst.begin(), worst.end(), [&](const BopTarget* a, const BopTarget* b) {
    return relative(a) > relative(b);
  });
  if (worst.size() > kMostWorst) worst.resize(kMostWorst);
  return worst;
}

std::string worst_html(const ScoredResults& input) {
  mustache::data rows(mustache::data::type::list);
  for (const BopTarget* target : worst_of(input)) {
    const BopPair& pair = *chosen_of(*target);
    const BopImage& image = input.dataset.images[target->image];
    const BopEstimate& estimate = input.estimates[pair.estimate];
    const double diameter_mm = input.dataset.models.at(target->obj_id).diameter_mm;
    mustache::data cells(mustache::data::type::list);
    const std::vector<std::string> values = {fmt::to_string(image.im_id),
                                             fmt::to_string(target->obj_id),
                                             fmt::to_string(target->instance),
                                             fmt::to_string(estimate.line),
                                             fmt::format("{:.3g}", estimate.score),
                                             measure(100 * pair.mssd_mm / diameter_mm),
                                             measure(pair.mspd_px),
                                             measure(100 * pair.add_mm / diameter_mm),
                                             measure(pair.theta_error_deg),
                                             measure(pair.t_error_percent),
                                             measure(pair.geodesic_deg)};
    for (const std::string& value : values) {
      cells << mustache::object{{"value", value}, {"interval", ""}};
    }
    rows << mustache::object{{"head", fmt::to_string(image.scene_id)}, {"cells", cells}};
  }
  return table_html("Worst estimates",
                    "The estimates with the greatest MSSD over the diameter, and their lines in "
                    "the results file.",
                    {"scene", "image", "object", "instance", "line", "score", "MSSD, %", "MSPD, px",
                     "ADD, %", "θ error, °", "T error, %", "geodesic, °"},
                    std::move(rows));
}

std::string pictures_html(const ScoredResults& input) {
  const std::vector<const BopTarget*> worst = worst_of(input);
  const size_t count = std::min(worst.size(), kMostPictures);
  return score_pictures(input.dataset, std::span(worst).first(count), input.estimates);
}

std::string definitions_html(const ScoredResults& input) {
  mustache::data facts(mustache::data::type::list);
  const auto add = [&](const std::string& key, const std::string& value) {
    facts << mustache::object{{"key", key}, {"value", value}};
  };
  add("version", SIGHTLINE_VERSION);
  add("results", input.results);
  add("data set", input.set);
  add("estimates", fmt::to_string(input.estimates.size()));
  add("VSD’s δ", fmt::format("{} mm", input.vsd_delta_mm));
  return mustache::mustache(page_text("score_definitions.mustache"))
      .render(mustache::object{{"facts", facts}});
}

std::vector<PageSection> sections_of(const ScoredResults& input) {
  return {
      {"answer", "Answer", answer_html(input), {}},
      {"scores", "Scores by object", objects_html(input), {}},
      {"recalls", "Recall by threshold", "", recall_charts(input)},
      {"cumulative", "Cumulative errors", "", error_charts(input, "cumulative", cumulative_chart)},
      {"boxes", "Spread of the errors", "", error_charts(input, "boxes", box_chart)},
      {"worst", "Worst estimates", worst_html(input) + pictures_html(input), {}},
      {"definitions", "Provenance and definitions", definitions_html(input), {}}};
}

}  // namespace

std::vector<Chart> score_charts(const ScoredResults& input) {
  std::vector<Chart> charts = recall_charts(input);
  for (std::vector<Chart> more : {error_charts(input, "cumulative", cumulative_chart),
                                  error_charts(input, "boxes", box_chart)}) {
    std::move(more.begin(), more.end(), std::back_inserter(charts));
  }
  return charts;
}

std::string score_report(const ScoredResults& input) {
  const auto targets = static_cast<int64_t>(input.scores.targets.size());
  const std::string given =
      fmt::format("Estimates <code>{}</code> against <code>{}</code>: {}, version {}.",
                  escape_html(input.results), escape_html(input.set), counted(targets, "instance"),
                  SIGHTLINE_VERSION);
  return render_page({"Scores of " + input.results, given, "", sections_of(input)});
}

}  // namespace sightline
