// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/coverage.h"

#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "eval/program/commands/commands.h"
#include "eval/study/study_file.h"
#include "eval/work/interrupt.h"
#include "eval/work/memory.h"
#include "eval/work/progress.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

struct CoverageArguments {
  std::string study;
  int repeats = 200;
  StudyOverrides overrides;
  bool is_quiet = false;
  bool is_json = false;
};

void run_coverage(const CoverageArguments& arguments) {
  remember_interrupts();
  const Study study = read_study(arguments.study, arguments.overrides);
  const std::string problem = why_no_memory_for_runs(study, arguments.repeats, free_memory_bytes());
  if (!problem.empty()) {
    throw InputError(fmt::format("{}: {}; take fewer --repeats or --trials", study.name, problem));
  }
  const int passes = study.images() != nullptr ? 2 : 1;
  Progress progress("coverage", int64_t{passes} * arguments.repeats, !arguments.is_quiet);
  CoverageOptions options;
  options.repeats = arguments.repeats;
  options.tick = [&] {
    stop_if_interrupted();
    progress.advance(1);
  };
  const auto coverage = interval_coverage(study, options);
  if (arguments.is_json) {
    std::cout << coverage_json(study, arguments.repeats, coverage);
    return;
  }
  std::cout
      << fmt::format(
             "{}, {} runs of {} trials: how often 95 % intervals hold the number of all runs\n\n",
             study.name, arguments.repeats, study.trial_count())
      << coverage_table(coverage);
}

}  // namespace

void add_coverage(CLI::App& app) {
  auto arguments = std::make_shared<CoverageArguments>();
  CLI::App* sub = app.add_subcommand(
      "coverage", "Run a study many times with other seeds and count how often its intervals hold");
  sub->add_option("study", arguments->study, "Name of a study or its file")->required();
  sub->add_option("--repeats", arguments->repeats, "Runs, with the seeds behind the study's")
      ->check(CLI::Range(2, 100000))
      ->capture_default_str();
  sub->add_option("--trials", arguments->overrides.trials, "Trials a run, as of `study`");
  sub->add_option("--seed", arguments->overrides.seed, "Seed that the runs' follow")
      ->check(CLI::NonNegativeNumber);
  sub->add_option("--set", arguments->overrides.set, "key=value of the study; may be repeated")
      ->allow_extra_args(false);
  sub->add_flag("--quiet", arguments->is_quiet, "No progress");
  sub->add_flag("--json", arguments->is_json, "Print JSON instead of the table");
  sub->callback([arguments] { run_coverage(*arguments); });
}

}  // namespace sightline
