// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Do the 95 % intervals of a study hold? It is run many times with other seeds; what all of its
// runs say together stands for the truth, and counted is how many runs' intervals hold it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "eval/study/study.h"
#include "renderer/renderer.h"

namespace sightline {

/// How often the intervals of one number of summary.json hold the truth, over a study's cells.
struct NumberCoverage {
  std::string name;  ///< as compare's measures have it: "theta_error_deg.mean"
  int cells = 0;    ///< that print an interval in half of the runs or more, and whose number varies
  double mean = 0;  ///< of those cells' rates
  double least = 1;        ///< of the cells
  std::string least_cell;  ///< its condition and solver
  double without = 0;      ///< the share of runs and cells that print a number and no interval
};

struct CoverageOptions {
  int repeats = 200;
  RendererOptions renderer;
  std::function<void()> tick = [] {};  ///< called for every repeat
};

/// Why there is no memory for that many runs of a study, from what is kept of each (its cells), of
/// all trials together and, with images, of the trials of one run; empty where there is enough, or
/// where nobody knows. To be asked before work begins.
std::string why_no_memory_for_runs(const Study& study, int repeats,
                                   std::optional<double> free_bytes);

/// Runs the study `repeats` times, with the seeds that follow its own, in this process. A number
/// that is the same in all runs and their sum (a rate of 0, the ratio of a solver to itself) has
/// nothing to cover and is left out, and so is what a cell prints no interval of. Numbers stand in
/// the order of summary.json.
std::vector<NumberCoverage> interval_coverage(const Study& study, const CoverageOptions& options);

/// The table of them, for the terminal and the docs (Markdown).
std::string coverage_table(const std::vector<NumberCoverage>& numbers);

/// All numbers as JSON, those without an interval too: their rates are null.
std::string coverage_json(const Study& study, int repeats,
                          const std::vector<NumberCoverage>& numbers);

}  // namespace sightline
