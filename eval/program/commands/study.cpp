// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "eval/output/json.h"
#include "eval/output/terminal.h"
#include "eval/program/commands/commands.h"
#include "eval/program/mesh_options.h"
#include "eval/program/run_command.h"
#include "eval/run/run.h"
#include "eval/study/study_file.h"
#include "eval/tables/plan_table.h"
#include "eval/work/interrupt.h"
#include "eval/work/private_folder.h"
#include "renderer/renderer.h"

namespace sightline {
namespace {

constexpr int kPilotTrials = 100;  // a condition

struct StudyArguments {
  std::string study;
  RunArguments run;
  MeshUse mesh;
  double planned_width = 0;  // relative half-width of the means' intervals; 0: run the study
};

// Says how many trials a condition needs for intervals so wide, from a pilot of few.
int plan_command(const StudyArguments& arguments) {
  remember_interrupts();
  StudyOverrides overrides = overrides_of(arguments.run);
  if (!overrides.trials) overrides.trials = kPilotTrials;
  const Study study = read_study(arguments.study, overrides);
  RunOptions options = run_options(study, arguments.run);
  const PrivateFolder folder;
  options.out = folder.path() / "pilot";
  const Summary summary = run_pilot(study, options);
  const double width = arguments.planned_width;
  std::cout << (arguments.run.is_json ? json_text(plan_json(study, summary, width))
                                      : shown(plan_table(study, summary, width)));
  return 0;
}

// How the mesh was taken, and what of it is not drawn.
void print_mesh_notes(const Study& study) {
  const PoseStudy* const poses = study.pose_study();
  if (poses == nullptr) return;
  for (const std::string& note : poses->target->mesh.notes) {
    std::cerr << fmt::format("note: {}: {}\n", poses->target->name, note);
  }
}

int run_study_command(const StudyArguments& arguments, const std::string& command) {
  if (arguments.planned_width > 0) return plan_command(arguments);
  remember_interrupts();
  const Study study = read_study(arguments.study, overrides_of(arguments.run));
  print_mesh_notes(study);
  return run_command(study, arguments.run, results_folder(study.name, arguments.run), command);
}

// Who draws: our own rasteriser unless OpenGL is asked for.
void add_gl(CLI::App& sub, std::string& gl) {
  const auto names = gl_choice_names();
  sub.add_option("--gl", gl, "Draw with OpenGL, to compare: auto, osmesa or egl (see doctor)")
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())))
      ->capture_default_str();
}

}  // namespace

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
  add_mesh_options(*sub, arguments->mesh);
  add_guest_options(*sub, arguments->run.guests);
  add_run_options(*sub, out, arguments->run);
  add_gl(*sub, arguments->run.gl);
  sub->add_option("--plan", arguments->planned_width,
                  "Only say how many trials a condition needs for 95 % intervals of the means of "
                  "+- this part of them (0.05: 5 %), from a pilot of --trials [100] each")
      ->check(CLI::Range(1e-6, 1.0))
      ->excludes(out);
  sub->callback([arguments, command, &exit_code] {
    for (std::string& setting : mesh_settings(arguments->mesh)) {
      arguments->run.overrides.set.push_back(std::move(setting));
    }
    exit_code = run_study_command(*arguments, command);
  });
}

}  // namespace sightline
