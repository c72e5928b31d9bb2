// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/coverage.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "eval/output/json.h"
#include "eval/run/trial_runner.h"
#include "eval/statistics/error_statistics.h"
#include "eval/summary/quantities.h"
#include "eval/summary/summary.h"
#include "scenes/files/pauses.h"

namespace sightline {
namespace {

// A number of a cell, with its interval if it has one.
struct CellNumber {
  std::string name;
  Measured measured;
};

void add_errors(const std::string& name, const ErrorSummary& errors,
                std::vector<CellNumber>& numbers) {
  numbers.push_back({name + ".mean", {errors.mean, errors.mean_ci95}});
  numbers.push_back({name + ".median", {errors.median, errors.median_ci95}});
  numbers.push_back({name + ".rms", {errors.rms, errors.rms_ci95}});
  numbers.push_back({name + ".p90", {errors.p90, errors.p90_ci95}});
}

double rate_of(int64_t count, int64_t trials) {
  return trials > 0 ? static_cast<double>(count) / static_cast<double>(trials) : kNoNumber;
}

// Everything that summary.json gives an interval of.
std::vector<CellNumber> numbers_of(const CellSummary& cell) {
  std::vector<CellNumber> numbers;
  for (const Quantity& quantity : quantities()) {
    if (!quantity.is_time) add_errors(quantity.name, cell.*quantity.summary, numbers);
  }
  numbers.push_back({"ratio_to_oracle", {cell.ratio_to_oracle, kNoInterval}});
  numbers.push_back({"ratio_to_oracle_median", cell.ratio_to_oracle_median});
  numbers.push_back({"ratio_to_bound", {cell.ratio_to_bound, kNoInterval}});
  numbers.push_back({"ratio_to_bound_median", cell.ratio_to_bound_median});
  numbers.push_back({"nees.mean", {cell.nees.mean, kNoInterval}});
  numbers.push_back({"nees.median", cell.nees.median});
  numbers.push_back({"nees.coverage95", {cell.nees.coverage95, cell.nees.coverage95_ci95}});
  numbers.push_back(
      {"failure_rate", {rate_of(cell.failures, cell.trials), cell.failure_rate_ci95}});
  numbers.push_back({"exact_set_rate", {cell.exact_set_rate, cell.exact_set_rate_ci95}});
  return numbers;
}

// The cells of each run, which is all that is kept of it.
using Runs = std::vector<std::vector<CellSummary>>;

// The study's runs, one behind the other.
class Repeater {
 public:
  Repeater(const Study& study, const CoverageOptions& options)
      : study_(study), runner_(study, options.renderer) {}

  // The cells of run r; every trial is shown to `visit`, numbered behind those of the runs before,
  // which keeps its condition. With images, which a summary goes through twice, the trials of a
  // run are kept for as long; others are not.
  std::vector<CellSummary> cells_of_run(int r, const TrialVisitor& visit) {
    if (study_.images() == nullptr) {
      const TrialSource run = [&](const TrialVisitor& visit_in_run) {
        each_trial(r, [&](TrialRecord& trial) {
          visit_in_run(trial);
          show(r, trial, visit);
        });
      };
      return summarise(study_, run).cells;
    }
    std::vector<TrialRecord> trials;
    each_trial(r, [&](TrialRecord& trial) { trials.push_back(std::move(trial)); });
    std::vector<CellSummary> cells = summarise(study_, trials).cells;
    for (TrialRecord& trial : trials) show(r, trial, visit);
    return cells;
  }

  // The same without its cells.
  void go_through_run(int r, const TrialVisitor& visit) {
    each_trial(r, [&](TrialRecord& trial) { show(r, trial, visit); });
  }

 private:
  template <typename Use>
  void each_trial(int r, const Use& use) {
    for (int64_t i = 0; i < study_.trial_count(); ++i) {
      take_pause();
      TrialRecord trial = runner_.run(i, study_.seed + 1 + static_cast<uint64_t>(r));
      use(trial);
    }
  }

  void show(int r, TrialRecord& trial, const TrialVisitor& visit) const {
    trial.trial += r * study_.trial_count();
    visit(trial);
  }

  const Study& study_;
  TrialRunner runner_;
};

// The summary of all runs' trials together, and of each run.
Summary run_all(const Study& study, const CoverageOptions& options, Runs& runs) {
  Repeater repeater(study, options);
  return summarise(study, [&](const TrialVisitor& visit) {
    const bool is_first_pass = runs.empty();  // an image study is gone through twice
    for (int r = 0; r < options.repeats; ++r) {
      if (is_first_pass) {
        runs.push_back(repeater.cells_of_run(r, visit));
      } else {
        repeater.go_through_run(r, visit);
      }
      options.tick();
    }
  });
}

// One number of one cell over the runs.
struct Tally {
  double truth = kNoNumber;
  int printed = 0;    // runs in which it is a number
  int intervals = 0;  // of them, those with an interval
  int held = 0;       // of those, those that hold the truth
  bool varies = false;

  void add(const Measured& measured) {
    if (std::isnan(measured.value)) return;
    ++printed;
    varies = varies || measured.value != truth;
    const auto [low, high] = measured.ci95;
    if (std::isnan(low) && std::isnan(high)) return;
    ++intervals;
    held += !(low > truth) && !(high < truth);  // an end that is not known holds everything
  }
};

void add_cell(const std::string& cell, const Tally& tally, NumberCoverage& number) {
  if (!tally.varies || 2 * tally.intervals < tally.printed) return;
  const double rate = static_cast<double>(tally.held) / tally.intervals;
  number.mean += (rate - number.mean) / ++number.cells;
  if (rate >= number.least) return;
  number.least = rate;
  number.least_cell = cell;
}

}  // namespace

std::string why_no_memory_for_runs(const Study& study, int repeats,
                                   std::optional<double> free_bytes) {
  // Of a trial a summary keeps the errors of each solver, up to a number of them; a run with images
  // keeps its trials too.
  constexpr double kErrorBytes = 100;
  constexpr double kEstimateBytes = 1200;
  constexpr double kBytesAGigabyte = 1e9;
  const double solvers = static_cast<double>(std::max<size_t>(1, study.solver_names().size()));
  const double cells = solvers * static_cast<double>(study.conditions.size());
  const double of_runs = sizeof(CellSummary) * cells * repeats;
  const double draws = std::min(static_cast<double>(study.draws) * repeats,
                                static_cast<double>(ErrorStatistics::kMostValuesKept));
  const double of_all = kErrorBytes * cells * draws;
  const bool keeps_trials = study.images() != nullptr;
  const double of_trials = keeps_trials ? kEstimateBytes * solvers * study.trial_count() : 0;
  const double needed = of_runs + of_all + of_trials;
  if (!free_bytes || needed <= *free_bytes) return "";
  return fmt::format(
      "{} runs of {} trials with {} cells (conditions times solvers) take {:.1f} GB, and {:.1f} GB "
      "are free",
      repeats, study.trial_count(), cells, needed / kBytesAGigabyte,
      std::max(0.0, *free_bytes) / kBytesAGigabyte);
}

std::vector<NumberCoverage> interval_coverage(const Study& study, const CoverageOptions& options) {
  Runs runs;
  const Summary all = run_all(study, options, runs);
  std::vector<NumberCoverage> coverage;
  for (const CellNumber& number : numbers_of(all.cells.front())) {
    coverage.emplace_back().name = number.name;
  }
  std::vector<int64_t> printed(coverage.size()), without(coverage.size());
  for (size_t c = 0; c < all.cells.size(); ++c) {
    const std::vector<CellNumber> truths = numbers_of(all.cells[c]);
    std::vector<Tally> tallies(truths.size());
    for (size_t i = 0; i < truths.size(); ++i) tallies[i].truth = truths[i].measured.value;
    for (const std::vector<CellSummary>& run : runs) {
      const std::vector<CellNumber> numbers = numbers_of(run[c]);
      for (size_t i = 0; i < numbers.size(); ++i) tallies[i].add(numbers[i].measured);
    }
    const std::string& label = study.conditions[static_cast<size_t>(all.cells[c].condition)].label;
    for (size_t i = 0; i < tallies.size(); ++i) {
      printed[i] += tallies[i].printed;
      without[i] += tallies[i].printed - tallies[i].intervals;
      add_cell(fmt::format("{}, {}", label, all.cells[c].solver), tallies[i], coverage[i]);
    }
  }
  for (size_t i = 0; i < coverage.size(); ++i) {
    coverage[i].without = printed[i] > 0 ? rate_of(without[i], printed[i]) : 0;
  }
  return coverage;
}

std::string coverage_table(const std::vector<NumberCoverage>& numbers) {
  std::string text =
      "| number | cells | mean | least | in the cell | without an interval |\n"
      "|---|---|---|---|---|---|\n";
  for (const NumberCoverage& number : numbers) {
    if (number.cells == 0 && number.without == 0) continue;
    text += number.cells == 0
                ? fmt::format("| {} | 0 | | | | {:.1f} % |\n", number.name, 100 * number.without)
                : fmt::format("| {} | {} | {:.1f} % | {:.1f} % | {} | {:.1f} % |\n", number.name,
                              number.cells, 100 * number.mean, 100 * number.least,
                              number.least_cell, 100 * number.without);
  }
  return text;
}

std::string coverage_json(const Study& study, int repeats,
                          const std::vector<NumberCoverage>& numbers) {
  Json json = {{"study", study.name},
               {"repeats", repeats},
               {"trials", study.trial_count()},
               {"numbers", Json::array()}};
  for (const NumberCoverage& number : numbers) {
    const bool has_cells = number.cells > 0;
    json["numbers"].push_back({{"number", number.name},
                               {"cells", number.cells},
                               {"mean", has_cells ? Json(number.mean) : Json()},
                               {"least", has_cells ? Json(number.least) : Json()},
                               {"least_cell", has_cells ? Json(number.least_cell) : Json()},
                               {"without_interval", number.without}});
  }
  return json_text(json);
}

}  // namespace sightline
