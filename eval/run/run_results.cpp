// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/run_results.h"

#include "eval/output/output_folder.h"
#include "eval/report/evidence.h"
#include "eval/report/gnuplot.h"
#include "eval/report/report.h"
#include "eval/results/expected_trials.h"
#include "eval/results/results_csv.h"
#include "eval/run/manifest.h"
#include "eval/run/run_folder.h"
#include "eval/summary/summary_json.h"
#include "eval/work/interrupt.h"
#include "renderer/renderer.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// The charts of single trials (cumulative curves, boxes, paired differences) and the frames are of
// studies up to this size; a trial takes some kilobytes.
constexpr int64_t kMostTrialsDrawn = 100'000;

bool could_be_run(const TrialRecord& trial) {
  return !trial.observations().empty() || !trial.orientations().empty();
}

// The trials of a store one by one, checked and counted: `result` knows them all after one pass.
TrialSource counted_trials(const Study& study, const Store& store, RunResult& result) {
  return [&, expected = expected_trials(study, store)](const TrialVisitor& visit) {
    result.trials = 0;
    result.failed_trials = 0;
    const NextTrial next = checked_reader(store, expected);
    for (auto trial = next(); trial; trial = next()) {
      stop_if_interrupted();
      ++result.trials;
      result.failed_trials += !could_be_run(*trial);
      visit(*trial);
    }
  };
}

}  // namespace

RunResult summarise_store(const Study& study, const Store& store) {
  RunResult result;
  result.summary = summarise(study, counted_trials(study, store, result));
  return result;
}

RunResult write_results(const Study& study, const Store& store, const nlohmann::json& manifest,
                        const fs::path& folder) {
  RunResult result = summarise_store(study, store);
  const TrialSource source = counted_trials(study, store, result);
  write_file(folder / "results.csv", [&](std::ostream& out) { write_csv(study, source, out); });
  write_file(folder / "summary.json", to_json(study, result.summary));
  if (study.takes_times()) {
    write_file(folder / "timings.csv",
               [&](std::ostream& out) { write_timings_csv(study, source, out); });
  }
  // What is shown of single trials needs them all at once.
  std::vector<TrialRecord> trials;
  if (store.size() <= kMostTrialsDrawn) trials = store.trials();
  std::vector<FrameEvidence> frames;
  if (study.images() != nullptr) {
    write_file(folder / kOutliersFile, to_json(outlier_model_of(trials), study.name));
    Renderer renderer;
    frames = gather_evidence(study, trials, renderer);
  }
  stop_if_interrupted();
  const ReportInput input{study, result.summary, trials, frames, as_texts(manifest)};
  write_file(folder / kReportFile, render_report(input));
  const fs::path figures = folder / "figures";
  std::error_code error;
  if (fs::is_symlink(figures)) fs::remove(figures, error);  // nothing is written through a link
  result.figures_note = write_figures(figures, report_charts(input));
  return result;
}

}  // namespace sightline
