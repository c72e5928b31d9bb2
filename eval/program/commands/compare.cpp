// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/compare.h"

#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "eval/compare/compare_text.h"
#include "eval/compare/junit.h"
#include "eval/output/output_folder.h"
#include "eval/output/terminal.h"
#include "eval/program/commands/commands.h"
#include "eval/work/interrupt.h"

namespace sightline {
namespace {

constexpr int kRegressionExit = 3;

struct CompareArguments {
  std::string base;
  std::string now;
  double tolerance = 0;
  std::vector<std::string> measures;
  std::string junit;
  std::string markdown;
  bool is_json = false;
};

}  // namespace

void add_compare(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* sub = app.add_subcommand(
      "compare", "Say of every cell whether a run is better, worse or unchanged; exit 3 if worse");
  sub->add_option("base", arguments->base,
                  "Folder of a run or its summary.json, or of `score` or its targets.csv")
      ->required();
  sub->add_option("new", arguments->now, "The same of what is to be judged")->required();
  sub->add_option("--tolerance", arguments->tolerance,
                  "Allow errors to change by this part (0.05: 5 %), rates by this part of the "
                  "trials")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  sub->add_option("--measure", arguments->measures,
                  "What to judge by, such as geodesic_deg.median,found_rate: `sightline list "
                  "measures` has them all [mean and middle of geodesic_deg and t_error_percent, "
                  "failure_rate]")
      ->type_name("NAME,...")
      ->allow_extra_args(false);
  sub->add_option("--junit", arguments->junit, "Also write JUnit XML, a test case a cell");
  sub->add_option("--markdown", arguments->markdown, "Also write all numbers as Markdown");
  sub->add_flag("--json", arguments->is_json, "Print all numbers as JSON, instead of the tables");
  sub->callback([arguments, &exit_code] {
    remember_interrupts();
    const Comparison comparison =
        compare_runs(arguments->base, arguments->now, arguments->tolerance, arguments->measures);
    std::cout << (arguments->is_json ? to_json(comparison) : shown(to_text(comparison)));
    if (!arguments->junit.empty()) write_file(arguments->junit, to_junit(comparison));
    if (!arguments->markdown.empty()) write_file(arguments->markdown, to_markdown(comparison));
    exit_code = comparison.has_regression() ? kRegressionExit : 0;
  });
}

}  // namespace sightline
