// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/commands.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <unistd.h>

#include "eval/compare/compare.h"
#include "eval/output/output_folder.h"
#include "eval/program/catalogue_lists.h"
#include "eval/program/doctor.h"
#include "eval/program/evaluate_command.h"
#include "eval/program/render_command.h"
#include "eval/program/run_command.h"
#include "eval/program/score_command.h"
#include "eval/run/run.h"
#include "eval/tables/result_table.h"
#include "eval/target/target_report.h"
#include "eval/work/interrupt.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr int kRegressionExit = 3;
constexpr int kPilotTrials = 100;  // a condition

// results/<study>, or the first of results/<study>-2, -3, ... that is free.
fs::path free_folder(const std::string& study) {
  const auto is_taken = [](const fs::path& folder) {
    return fs::exists(folder) || fs::exists(staging_folder(folder));
  };
  const fs::path first = fs::path("results") / study;
  fs::path folder = first;
  for (int i = 2; is_taken(folder); ++i) folder = fmt::format("{}-{}", first.string(), i);
  return folder;
}

struct StudyArguments {
  std::string study;
  RunArguments run;
  double planned_width = 0;  // relative half-width of the means' intervals; 0: run the study
};

// Says how many trials a condition needs for intervals so wide, from a pilot of few.
int plan_command(const StudyArguments& arguments) {
  remember_interrupts();
  StudyOverrides overrides = arguments.run.overrides;
  if (!overrides.trials) overrides.trials = kPilotTrials;
  const Study study = read_study(arguments.study, overrides);
  RunOptions options = run_options(arguments.run);
  options.out = fs::temp_directory_path() / fmt::format("sightline-plan-{}", getpid());
  const Summary summary = run_pilot(study, options);
  std::cout << plan_table(study, summary, arguments.planned_width);
  return 0;
}

int run_study_command(const StudyArguments& arguments, const std::string& command) {
  if (arguments.planned_width > 0) return plan_command(arguments);
  remember_interrupts();
  const Study study = read_study(arguments.study, arguments.run.overrides);
  const fs::path out =
      arguments.run.out.empty() ? free_folder(study.name) : fs::path(arguments.run.out);
  return run_command(study, arguments.run, out, command);
}

// Who draws: our own rasteriser unless OpenGL is asked for.
void add_gl(CLI::App& sub, std::string& gl) {
  const auto names = gl_choice_names();
  sub.add_option("--gl", gl, "Draw with OpenGL, to compare: auto, osmesa or egl (see doctor)")
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())))
      ->capture_default_str();
}

void add_study(CLI::App& app, const std::string& command, int& exit_code) {
  auto arguments = std::make_shared<StudyArguments>();
  CLI::App* sub = app.add_subcommand(
      "study", "Run a study: render, extract, solve, compare with the truth, report");
  sub->add_option("study", arguments->study, "Name (see `sightline list studies`) or a .toml file")
      ->required();
  CLI::Option* out =
      sub->add_option("--out", arguments->run.out,
                      "Folder for the results [results/<study>, or -2, -3, ... if that exists]");
  sub->add_option("--trials", arguments->run.overrides.trials,
                  "Trials of each condition, instead of the study's");
  sub->add_option("--set", arguments->run.overrides.set,
                  "key=value over the study's file, for example noise.scale=2; may be repeated")
      ->allow_extra_args(false);
  add_run_options(*sub, out, arguments->run);
  add_gl(*sub, arguments->run.gl);
  sub->add_option("--plan", arguments->planned_width,
                  "Only say how many trials a condition needs for 95 % intervals of the means of "
                  "+- this part of them (0.05: 5 %), from a pilot of --trials [100] each")
      ->check(CLI::Range(1e-6, 1.0))
      ->excludes(out);
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

struct CompareArguments {
  std::string base;
  std::string now;
  double tolerance = 0;
  std::string junit;
  std::string markdown;
};

void add_compare(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* sub = app.add_subcommand(
      "compare", "Say of every cell whether a run is better, worse or unchanged; exit 3 if worse");
  sub->add_option("base", arguments->base, "Folder of a run, or its summary.json")->required();
  sub->add_option("new", arguments->now, "The same of the run to judge")->required();
  sub->add_option("--tolerance", arguments->tolerance,
                  "Allow means to change by this part (0.05: 5 %), failures by this part of the "
                  "trials")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  sub->add_option("--junit", arguments->junit, "Also write JUnit XML, a test case a cell");
  sub->add_option("--markdown", arguments->markdown, "Also write all numbers as Markdown");
  sub->callback([arguments, &exit_code] {
    remember_interrupts();
    const Comparison comparison =
        compare_runs(arguments->base, arguments->now, arguments->tolerance);
    std::cout << to_text(comparison);
    if (!arguments->junit.empty()) write_file(arguments->junit, to_junit(comparison));
    if (!arguments->markdown.empty()) write_file(arguments->markdown, to_markdown(comparison));
    exit_code = comparison.has_regression() ? kRegressionExit : 0;
  });
}

void add_list(CLI::App& app) {
  auto what = std::make_shared<std::string>();
  CLI::App* sub =
      app.add_subcommand("list", "List targets, extractors, solvers, methods and studies");
  sub->add_option(
      "what", *what,
      "targets, extractors, solvers, methods or studies; all without. Or columns: of results");
  sub->callback([what] { std::cout << catalogue_lists(*what); });
}

void add_target(CLI::App& app) {
  auto arguments = std::make_shared<TargetArguments>();
  CLI::App* sub = app.add_subcommand(
      "target", "Say what a mesh or a target holds: size, parts, closedness, edges, features");
  sub->add_option("target", arguments->target, "Name of a target, a target.toml or a mesh file")
      ->required();
  sub->add_option("--forward", arguments->forward,
                  "For a mesh file: its axis that points forward, x to -z [x]");
  sub->add_option("--up", arguments->up, "For a mesh file: its axis that points up [-z]");
  sub->add_option("--unit", arguments->unit,
                  "For a mesh file: its unit, m, cm, mm, km, in, ft or metres as a number [m]");
  sub->add_option("--picture", arguments->picture, "Also draw it into this .png");
  sub->add_option("--theta", arguments->theta_deg,
                  "Pitch, yaw and roll of the picture in degrees, comma-separated; 0,0,0 is the "
                  "target's z axis away from the camera (a shipped target's plan view)")
      ->delimiter(',')
      ->expected(3)
      ->capture_default_str();
  CLI::Option* propose =
      sub->add_option("--propose", arguments->propose,
                      "Find features where straight sharp edges meet; write target.toml, mesh.glb "
                      "and features.png (or --picture) into this folder [its name]")
          ->expected(0, 1);
  sub->add_option("--max-features", arguments->max_features, "How many it may propose")
      ->check(CLI::Range(1, 1000))
      ->needs(propose)
      ->capture_default_str();
  sub->callback([arguments] { std::cout << report_target(*arguments); });
}

void add_doctor(CLI::App& app) {
  auto measures_renderer = std::make_shared<bool>(false);
  CLI::App* sub = app.add_subcommand(
      "doctor", "Say what the program stands on: libraries, folders, ways to draw, shards");
  sub->add_flag("--renderer", *measures_renderer,
                "Also measure the edges, vertices and time of every number of samples");
  sub->callback([measures_renderer] { std::cout << doctor(*measures_renderer); });
}

}  // namespace

void add_commands(CLI::App& app, const std::string& command, int& exit_code) {
  add_study(app, command, exit_code);
  add_render(app, exit_code);
  add_evaluate(app, command, exit_code);
  add_score(app);
  add_merge(app, command, exit_code);
  add_report(app);
  add_compare(app, exit_code);
  add_list(app);
  add_target(app);
  add_doctor(app);
}

}  // namespace sightline
