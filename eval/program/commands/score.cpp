// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/score/score.h"

#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "eval/output/output_folder.h"
#include "eval/program/commands/commands.h"
#include "eval/report/gnuplot.h"
#include "eval/score/score_report.h"
#include "eval/score/scores_files.h"
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
  const ScoredResults scored{arguments.results, arguments.dataset, arguments.vsd_delta_mm,
                             dataset,           estimates,         scores};
  write_file(out / "scores.json", scores_json(scored));
  write_file(out / "errors.csv", [&](std::ostream& file) { write_errors_csv(scored, file); });
  write_file(out / "report.html", score_report(scored));
  const std::string figures_note = write_figures(out / "figures", score_charts(scored));
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
