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
#include "eval/summary/quantities.h"
#include "eval/summary/summary.h"

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

using Runs = std::vector<Summary>;

// The summary of all runs' trials together, and of each run: the trials of run r are numbered
// behind those of the runs before, which keeps their conditions.
Summary run_all(const Study& study, const CoverageOptions& options, Runs& runs) {
  TrialRunner runner(study, options.renderer);
  const int64_t count = study.trial_count();
  return summarise(study, [&](const TrialVisitor& visit) {
    const bool is_first_pass = runs.empty();  // an image study is gone through twice
    for (int r = 0; r < options.repeats; ++r) {
      std::vector<TrialRecord> trials;
      for (int64_t i = 0; i < count; ++i) {
        trials.push_back(runner.run(i, study.seed + 1 + static_cast<uint64_t>(r)));
      }
      if (is_first_pass) runs.push_back(summarise(study, trials));
      for (TrialRecord& trial : trials) {
        trial.trial += r * count;
        visit(trial);
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
    for (const Summary& run : runs) {
      const std::vector<CellNumber> numbers = numbers_of(run.cells[c]);
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
