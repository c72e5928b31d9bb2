// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/score_command.h"

#include <array>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/csv.h"
#include "eval/output/json.h"
#include "eval/output/numbers.h"
#include "eval/output/output_folder.h"
#include "eval/output/text_table.h"
#include "eval/report/gnuplot.h"
#include "eval/score/score.h"
#include "eval/score/score_report.h"
#include "eval/work/interrupt.h"
#include "eval/work/progress.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

struct ScoreArguments {
  std::string results;
  std::string dataset;
  std::string split;
  std::string out;
  double vsd_delta_mm = 15;
  bool is_quiet = false;
};

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
  return {{"targets", s.targets},
          {"estimated", s.estimated},
          {"ar", rate_json(s.ar)},
          {"ar_mssd", rate_json(s.ar_mssd)},
          {"ar_mspd", rate_json(s.ar_mspd)},
          {"ar_vsd", rate_json(s.ar_vsd)},
          {"mssd_recalls", s.mssd_recalls},
          {"mspd_recalls", s.mspd_recalls},
          {"add_recall", rate_json(s.add)},
          {"adi_recall", rate_json(s.adi)},
          {"theta_error_deg", error_json(s.theta_error_deg)},
          {"t_error_percent", error_json(s.t_error_percent)},
          {"geodesic_deg", error_json(s.geodesic_deg)},
          {"projection_5px_recall", rate_json(s.projection_5px)},
          {"within_5deg_5cm", rate_json(s.within_5deg_5cm)},
          {"speed_score", error_json(s.speed_score)},
          {"speed_plus_score", error_json(s.speed_plus_score)}};
}

std::string scores_json(const ScoreArguments& arguments, const BopScores& scores,
                        size_t estimates) {
  Json objects = Json::array();
  for (const auto& [obj_id, summary] : summarise_by_object(scores)) {
    Json object = {{"obj_id", obj_id}};
    object.update(summary_json(summary));
    objects.push_back(std::move(object));
  }
  const Json json = {{"version", SIGHTLINE_VERSION},
                     {"results", arguments.results},
                     {"dataset", arguments.dataset},
                     {"vsd_delta_mm", arguments.vsd_delta_mm},
                     {"estimates", estimates},
                     {"ignored_estimates", scores.ignored_estimates},
                     {"all", summary_json(summarise(scores))},
                     {"objects", objects}};
  return json.dump(2) + "\n";
}

// ---- errors.csv

// A number of a pair of a target and an estimate of it.
struct PairColumn {
  std::string_view name;
  double BopPair::*number;
};
constexpr std::array kPairColumns = {PairColumn{"mssd_mm", &BopPair::mssd_mm},
                                     PairColumn{"mspd_px", &BopPair::mspd_px},
                                     PairColumn{"add_mm", &BopPair::add_mm},
                                     PairColumn{"adi_mm", &BopPair::adi_mm},
                                     PairColumn{"theta_error_deg", &BopPair::theta_error_deg},
                                     PairColumn{"t_error_percent", &BopPair::t_error_percent},
                                     PairColumn{"geodesic_deg", &BopPair::geodesic_deg},
                                     PairColumn{"projection_px", &BopPair::projection_px},
                                     PairColumn{"speed_score", &BopPair::speed_score},
                                     PairColumn{"speed_plus_score", &BopPair::speed_plus_score}};
constexpr std::array<std::string_view, 4> kTargetNames{"scene_id", "im_id", "obj_id", "gt_id"};
constexpr std::array<std::string_view, 3> kEstimateNames{"line", "score", "is_chosen"};
constexpr std::string_view kWithinName = "is_within_5deg_5cm";
// All but the target's.
constexpr size_t kPairFields = kEstimateNames.size() + kPairColumns.size() + 1 + kBopThresholds;

std::string errors_header() {
  CsvLine header;
  for (const std::string_view name : kTargetNames) header << name;
  for (const std::string_view name : kEstimateNames) header << name;
  for (const PairColumn& column : kPairColumns) header << column.name;
  header << kWithinName;
  for (int i = 0; i < kBopThresholds; ++i) header << fmt::format("vsd_{:.2f}", bop_fraction(i));
  return std::move(header).end();
}

CsvLine target_line(const BopImage& image, const BopTarget& target) {
  CsvLine line;
  line << image.scene_id << image.im_id << target.obj_id << static_cast<int64_t>(target.instance);
  return line;
}

void add_pair(CsvLine& line, const BopPair& pair, const BopEstimate& estimate, bool is_chosen) {
  line << estimate.line << estimate.score << int{is_chosen};
  for (const PairColumn& column : kPairColumns) line << pair.*column.number;
  line << int{pair.is_within_5deg_5cm};
  if (pair.vsd.empty()) line.empty_fields(kBopThresholds);
  for (const double error : pair.vsd) line << error;
}

// A row a target and estimate of it that counts; a target without any has one row without numbers.
void write_errors(const BopDataset& dataset, std::span<const BopEstimate> estimates,
                  const BopScores& scores, std::ostream& out) {
  out << errors_header();
  for (const BopTarget& target : scores.targets) {
    const BopImage& image = dataset.images[target.image];
    if (target.pairs.empty()) {
      out << std::move(target_line(image, target).empty_fields(kPairFields)).end();
    }
    for (size_t i = 0; i < target.pairs.size(); ++i) {
      const BopPair& pair = target.pairs[i];
      CsvLine line = target_line(image, target);
      add_pair(line, pair, estimates[pair.estimate], target.chosen == i);
      out << std::move(line).end();
    }
  }
}

// ---- the table

TextGroup rate_group(const std::string& name, const std::vector<BopRate>& rates) {
  TextGroup group{name, {{"", {}}, {"95 %", {}}}};
  for (const BopRate& rate : rates) {
    group.columns[0].cells.push_back(number_text(rate.value, 4));
    group.columns[1].cells.push_back(
        bracketed(number_text(rate.ci95[0], 4), number_text(rate.ci95[1], 4)));
  }
  return group;
}

std::string score_table(const BopScores& scores) {
  std::vector<std::string> labels{"all"};
  std::vector<BopSummary> rows{summarise(scores)};
  const auto by_object = summarise_by_object(scores);
  if (by_object.size() > 1) {
    for (const auto& [obj_id, summary] : by_object) {
      labels.push_back(fmt::format("object {}", obj_id));
      rows.push_back(summary);
    }
  }
  std::vector<TextGroup> recalls;
  const std::vector<std::pair<std::string, BopRate BopSummary::*>> rates = {
      {"AR", &BopSummary::ar},
      {"AR_MSSD", &BopSummary::ar_mssd},
      {"AR_MSPD", &BopSummary::ar_mspd},
      {"AR_VSD", &BopSummary::ar_vsd},
      {"ADD < 0.1 d", &BopSummary::add},
      {"ADI < 0.1 d", &BopSummary::adi},
      {"2D proj. < 5 px", &BopSummary::projection_5px},
      {"5 deg 5 cm", &BopSummary::within_5deg_5cm}};
  for (const auto& [name, member] : rates) {
    std::vector<BopRate> column;
    for (const BopSummary& row : rows) column.push_back(row.*member);
    recalls.push_back(rate_group(name, column));
  }
  TextColumn targets{"targets", {}}, estimated{"estimated", {}};
  TextColumn speed{"SPEED", {}}, speed_plus{"SPEED+", {}};
  TextColumn theta{"theta_error / °", {}}, t{"T_error / %", {}}, geodesic{"geodesic / °", {}};
  for (const BopSummary& row : rows) {
    targets.cells.push_back(fmt::to_string(row.targets));
    estimated.cells.push_back(fmt::to_string(row.estimated));
    theta.cells.push_back(number_text(row.theta_error_deg.median, 4));
    t.cells.push_back(number_text(row.t_error_percent.median, 4));
    geodesic.cells.push_back(number_text(row.geodesic_deg.median, 4));
    speed.cells.push_back(number_text(row.speed_score.mean, 4));
    speed_plus.cells.push_back(number_text(row.speed_plus_score.mean, 4));
  }
  return text_block("Recall, and its 95 % interval", labels, recalls) +
         text_block(
             "Medians of the targets, a missed one counting as infinite", labels,
             {{"", {targets}}, {"", {estimated}}, {"", {theta}}, {"", {t}}, {"", {geodesic}}}) +
         text_block(
             fmt::format("Mean scores of ESA's challenges, a missed target counting as {:.4f}",
                         kSpeedScoreCap),
             labels, {{"", {speed}}, {"", {speed_plus}}});
}

void print_notes(const BopScores& scores) {
  if (scores.ignored_estimates > 0) {
    std::cerr << fmt::format(
        "sightline: {} estimates are of nothing that is asked for, or more than are\n",
        scores.ignored_estimates);
  }
  if (!scores.has_vsd) {
    std::cerr << "sightline: the data set has images without depth, so there is no VSD and no AR\n";
  }
}

void run_score(const ScoreArguments& arguments) {
  remember_interrupts();
  const std::vector<BopEstimate> estimates = read_bop_results(arguments.results);
  const BopDataset dataset = read_bop_dataset(arguments.dataset, arguments.split);
  OutputFolder out(arguments.out);
  BopScores scores;
  {
    Progress progress("score", static_cast<int64_t>(dataset.images.size()), !arguments.is_quiet);
    scores = score_bop(dataset, estimates, arguments.vsd_delta_mm, [&] {
      stop_if_interrupted();
      progress.advance(1);
    });
  }
  write_file(out / "scores.json", scores_json(arguments, scores, estimates.size()));
  write_file(out / "errors.csv",
             [&](std::ostream& file) { write_errors(dataset, estimates, scores, file); });
  const ScoreReportInput report{arguments.results, arguments.dataset, arguments.vsd_delta_mm,
                                dataset,           estimates,         scores};
  write_file(out / "report.html", score_report(report));
  const std::string figures_note = write_figures(out / "figures", score_charts(report));
  out.commit();
  print_notes(scores);
  if (!figures_note.empty()) std::cerr << "sightline: " << figures_note << "\n";
  if (arguments.is_quiet) return;
  std::cout << score_table(scores)
            << fmt::format("\nreport: {}\n", (fs::path(arguments.out) / "report.html").string());
}

}  // namespace

void add_score(CLI::App& app) {
  auto arguments = std::make_shared<ScoreArguments>();
  CLI::App* sub = app.add_subcommand(
      "score", "Score anyone's estimates (a BOP results CSV) against a BOP data set");
  sub->add_option("results", arguments->results,
                  "The estimates: scene_id,im_id,obj_id,score,R,t,time with t in mm")
      ->required();
  sub->add_option("--dataset", arguments->dataset, "Folder of the data set, in BOP's format")
      ->required();
  sub->add_option("--out", arguments->out,
                  "Folder for report.html, figures/, scores.json and errors.csv")
      ->required();
  sub->add_option("--split", arguments->split, "Its folder of scenes [test, or the only test*]");
  sub->add_option("--vsd-delta-mm", arguments->vsd_delta_mm,
                  "How much nearer than the model the depth may be where VSD calls it visible")
      ->check(CLI::Range(1e-6, 1e9))
      ->capture_default_str();
  sub->add_flag("--quiet", arguments->is_quiet, "No progress and no table");
  sub->callback([arguments] { run_score(*arguments); });
}

}  // namespace sightline
