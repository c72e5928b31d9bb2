// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/commands.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "eval/catalogue_lists.h"
#include "eval/interrupt.h"
#include "eval/run.h"
#include "eval/table.h"
#include "eval/target_report.h"
#include "scenes/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr int kSomeTrialsNotRunExit = 4;

// results/<study>, or the first of results/<study>-2, -3, ... that is free.
fs::path free_folder(const std::string& study) {
  const fs::path first = fs::path("results") / study;
  fs::path folder = first;
  for (int i = 2; fs::exists(folder); ++i) folder = fmt::format("{}-{}", first.string(), i);
  return folder;
}

void print_result(const Study& study, const RunResult& result, const fs::path& out) {
  std::cout << to_table(study, result.summary)
            << "\nreport: " << fs::absolute(out / "report.html").string() << "\n";
}

// What a user should know of a result that is whole but for its figures.
void print_note(const RunResult& result) {
  if (!result.figures_note.empty()) std::cerr << "sightline: " << result.figures_note << "\n";
}

int exit_code_of(const RunResult& result) {
  if (result.failed_trials == 0) return 0;
  std::cerr << fmt::format("sightline: {} of {} trials could not be imaged (see results.csv)\n",
                           result.failed_trials, result.trials);
  return kSomeTrialsNotRunExit;
}

struct StudyArguments {
  std::string study;
  StudyOverrides overrides;
  std::string out;
  int jobs = 1;
  std::string shard;
  bool is_quiet = false;
};

int run_study_command(const StudyArguments& arguments, const std::string& command) {
  remember_interrupts();
  const Study study = read_study(arguments.study, arguments.overrides);
  RunOptions options;
  options.out = arguments.out.empty() ? free_folder(study.name) : fs::path(arguments.out);
  options.jobs = arguments.jobs;
  options.show_progress = !arguments.is_quiet;
  options.command = command;
  if (!arguments.shard.empty()) {
    const ShardChoice choice =
        read_shard(arguments.shard, [](const char* name) { return std::getenv(name); });
    options.shard = choice.shard;
    if (!arguments.is_quiet) {
      std::cerr << fmt::format("shard {} of {} ({})\n", choice.shard.index, choice.shard.count,
                               choice.source);
    }
  }
  const RunResult result = run_study(study, options);
  if (!arguments.is_quiet) print_result(study, result, options.out);
  print_note(result);
  return exit_code_of(result);
}

void add_study(CLI::App& app, const std::string& command, int& exit_code) {
  auto arguments = std::make_shared<StudyArguments>();
  CLI::App* sub = app.add_subcommand(
      "study", "Run a study: render, extract, solve, compare with the truth, report");
  sub->add_option("study", arguments->study, "Name (see `sightline list studies`) or a .toml file")
      ->required();
  sub->add_option("--out", arguments->out,
                  "Folder for the results [results/<study>, or -2, -3, ... if that exists]");
  sub->add_option("--trials", arguments->overrides.trials,
                  "Trials of each condition, instead of the study's");
  sub->add_option("--seed", arguments->overrides.seed, "Seed of all random draws")
      ->check(CLI::NonNegativeNumber);
  sub->add_option("--jobs", arguments->jobs, "Processes to run at once")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  sub->add_option("--shard", arguments->shard,
                  "Only trials with number mod N = I: I/N, auto or auto/N (from the engine)");
  sub->add_option("--set", arguments->overrides.set,
                  "key=value over the study's file, for example noise.scale=2; may be repeated")
      ->allow_extra_args(false);
  sub->add_flag("--quiet", arguments->is_quiet, "No progress and no table");
  sub->callback(
      [arguments, command, &exit_code] { exit_code = run_study_command(*arguments, command); });
}

void add_merge(CLI::App& app, const std::string& command, int& exit_code) {
  auto shards = std::make_shared<std::vector<fs::path>>();
  auto out = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand("merge", "Join the folders of a study's shards into one");
  sub->add_option("shards", *shards, "Folders of all shards of one study")->required();
  sub->add_option("--out", *out, "Folder for the joined results")->required();
  sub->callback([shards, out, command, &exit_code] {
    remember_interrupts();
    const RunResult result = merge_runs(*shards, *out, command);
    std::cout << "report: " << (fs::path(*out) / "report.html").string() << "\n";
    print_note(result);
    exit_code = exit_code_of(result);
  });
}

void add_report(CLI::App& app) {
  auto folder = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand(
      "report", "Write a run's results.csv, summary.json and report.html anew from its trials");
  sub->add_option("folder", *folder, "Folder of a run")->required();
  sub->callback([folder] {
    print_note(rewrite_report(*folder));
    std::cout << "report: " << (fs::path(*folder) / "report.html").string() << "\n";
  });
}

void add_list(CLI::App& app) {
  auto what = std::make_shared<std::string>();
  CLI::App* sub =
      app.add_subcommand("list", "List targets, extractors, solvers, methods and studies");
  sub->add_option("what", *what, "targets, extractors, solvers, methods or studies; all without");
  sub->callback([what] { std::cout << catalogue_lists(*what); });
}

void add_target(CLI::App& app) {
  auto arguments = std::make_shared<TargetArguments>();
  CLI::App* sub = app.add_subcommand(
      "target", "Say what a mesh or a target holds: size, parts, closedness, edges, features");
  sub->add_option("target", arguments->target, "Name of a target, a target.toml or a mesh file")
      ->required();
  sub->add_option("--forward", arguments->forward,
                  "For a mesh file: its axis that points forward, +x to -z [+x]");
  sub->add_option("--up", arguments->up, "For a mesh file: its axis that points up [-z]");
  sub->add_option("--picture", arguments->picture, "Also draw it into this .png");
  sub->add_option("--theta", arguments->theta_deg,
                  "Pitch, yaw and roll of the picture in degrees, comma-separated; 0,0,0 is the "
                  "target's z axis away from the camera (a shipped target's plan view)")
      ->delimiter(',')
      ->expected(3)
      ->capture_default_str();
  sub->callback([arguments] { std::cout << report_target(*arguments); });
}

}  // namespace

void add_commands(CLI::App& app, const std::string& command, int& exit_code) {
  add_study(app, command, exit_code);
  add_merge(app, command, exit_code);
  add_report(app);
  add_list(app);
  add_target(app);
}

}  // namespace sightline
