// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "eval/program/commands/commands.h"
#include "eval/program/run_command.h"
#include "eval/study/study_file.h"
#include "eval/work/interrupt.h"

namespace sightline {
namespace {

constexpr const char* kStudy = "boeing-table1";
constexpr int kTrials = 25;  // a pose: some ten seconds on two processors

constexpr const char* kBefore =
    "Renders a Boeing 707 in the four poses of ORPE's Table 1, 25 times each with new noise, "
    "finds\n"
    "five features in each image, and solves for the pose by ORPE, which removes outliers, by "
    "least\n"
    "squares (LSPE), and with the true inliers (oracle). The study proper has 100 images a "
    "pose.\n\n";

constexpr const char* kAfter = R"(
What next?
  sightline study boeing-table1          the whole study, with closer intervals
  sightline list                         targets, extractors, solvers and studies that are there
  sightline render cube --count 50 --out set     an image set with its exact truth
  sightline target MESH --propose NAME   features for a mesh of your own
)";

int run_demo(RunArguments arguments, const std::string& command) {
  remember_interrupts();
  arguments.overrides.trials = kTrials;
  const bool has_words = !arguments.is_quiet && !arguments.is_json;
  if (has_words) std::cout << kBefore << std::flush;
  const Study study = read_study(kStudy, overrides_of(arguments));
  const int exit_code = run_command(study, arguments, results_folder("demo", arguments), command);
  if (has_words) std::cout << kAfter;
  return exit_code;
}

}  // namespace

void add_demo(CLI::App& app, const std::string& command, int& exit_code) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* sub =
      app.add_subcommand("demo", "The main job in some ten seconds: images, poses, a report");
  CLI::Option* out = sub->add_option("--out", arguments->out,
                                     "Folder for the results [results/demo, or -2, -3, ...]");
  add_run_options(*sub, out, *arguments);
  sub->callback([arguments, command, &exit_code] { exit_code = run_demo(*arguments, command); });
}

}  // namespace sightline
