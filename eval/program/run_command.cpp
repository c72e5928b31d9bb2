// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/run_command.h"

#include <filesystem>
#include <iostream>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "eval/output/output_folder.h"
#include "eval/output/plain_text.h"
#include "eval/output/terminal.h"
#include "eval/summary/summary_json.h"
#include "eval/tables/result_table.h"
#include "eval/work/processors.h"
#include "eval/work/shard.h"

namespace sightline {
namespace fs = std::filesystem;
namespace {

constexpr int kSomeTrialsNotRunExit = 4;

void print_result(const Study& study, const RunResult& result, const RunArguments& arguments,
                  const std::filesystem::path& out) {
  if (arguments.is_json) {
    std::cout << to_json(study, result.summary);
    return;
  }
  std::cout << shown(to_table(study, result.summary))
            << "\nreport: " << plain_line(std::filesystem::absolute(out / "report.html").string())
            << "\n";
}

// Times that two processes take from each other say nothing of a method.
// And who gives every process a shard has spread the work himself: the ranks of mpirun share a
// machine.
int jobs_of(const Study& study, const RunArguments& arguments) {
  if (arguments.jobs > 0) return arguments.jobs;
  return study.takes_times() || !arguments.shard.empty() ? 1 : usable_processors();
}

}  // namespace

fs::path results_folder(const std::string& name, const RunArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  const auto is_taken = [](const fs::path& folder) {
    return fs::exists(folder) || fs::exists(staging_folder(folder));
  };
  const fs::path first = fs::path("results") / name;
  fs::path folder = first;
  for (int i = 2; is_taken(folder); ++i) folder = fmt::format("{}-{}", first.string(), i);
  return folder;
}

void add_run_options(CLI::App& sub, CLI::Option* out, RunArguments& arguments) {
  sub.add_flag("--resume", arguments.is_resumed,
               "Continue what a run into --out left that was killed or failed; begin where there "
               "is none. Finished trials then outlive an interrupt too")
      ->needs(out);
  sub.add_option("--seed", arguments.overrides.seed, "Seed of all random draws")
      ->check(CLI::NonNegativeNumber);
  sub.add_option("--jobs", arguments.jobs,
                 "Processes to run at once [as many as there are processors; one with --shard, and "
                 "where times are taken]")
      ->check(CLI::Range(1, 1024));
  sub.add_option("--shard", arguments.shard,
                 "Only trials with number mod N = I: I/N, auto or auto/N (from the engine)");
  sub.add_flag("--quiet", arguments.is_quiet, "No progress and no table");
  sub.add_flag("--json", arguments.is_json, "Print what summary.json holds, instead of the tables");
}

void print_note(const RunResult& result) {
  if (!result.figures_note.empty()) std::cerr << "sightline: " << result.figures_note << "\n";
}

int exit_code_of(const RunResult& result) {
  if (result.failed_trials == 0) return 0;
  std::cerr << fmt::format("sightline: {} of {} trials could not be run (see results.csv)\n",
                           result.failed_trials, result.trials);
  return kSomeTrialsNotRunExit;
}

StudyOverrides overrides_of(const RunArguments& arguments) {
  StudyOverrides overrides = arguments.overrides;
  // What is set by hand comes last, and counts.
  std::vector<std::string> settings = guest_settings(arguments.guests);
  settings.insert(settings.end(), overrides.set.begin(), overrides.set.end());
  overrides.set = std::move(settings);
  return overrides;
}

RunOptions run_options(const Study& study, const RunArguments& arguments) {
  RunOptions options;
  options.jobs = jobs_of(study, arguments);
  options.is_resumed = arguments.is_resumed;
  options.show_progress = !arguments.is_quiet;
  options.renderer.gl = gl_choice(arguments.gl).value();
  options.shard = chosen_shard(arguments.shard, !arguments.is_quiet);
  return options;
}

int run_command(const Study& study, const RunArguments& arguments, const std::filesystem::path& out,
                const std::string& command) {
  RunOptions options = run_options(study, arguments);
  options.out = out;
  options.command = command;
  const RunResult result = run_study(study, options);
  if (!arguments.is_quiet && result.resumed_trials > 0) {
    std::cerr << fmt::format("resumed: {} of {} trials were there\n", result.resumed_trials,
                             result.trials);
  }
  if (!arguments.is_quiet || arguments.is_json) {
    print_result(study, result, arguments, options.out);
  }
  print_note(result);
  return exit_code_of(result);
}

}  // namespace sightline
