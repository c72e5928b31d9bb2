// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/output/plain_text.h"
#include "eval/program/commands/commands.h"
#include "eval/program/run_command.h"
#include "eval/study/study_file.h"
#include "eval/work/interrupt.h"
#include "scenes/files/assets.h"
#include "scenes/files/input_error.h"
#include "scenes/files/toml_text.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDrawnPrior = "truth+error";
const std::vector<std::string> kSolvers = {"orpe", "orpe_weighed", "lspe", "oracle"};

struct EvaluateArguments {
  std::string dataset;
  std::string target;
  std::string split;
  std::string sensor;
  std::optional<int> object;
  std::string axes = "target";
  std::string prior = kDrawnPrior;
  std::vector<std::string> solvers = kSolvers;
  RunArguments run;
};

// The set's folder as the name of a run, which is to be a file's.
std::string name_of(const fs::path& dataset) {
  const fs::path folder = fs::absolute(dataset).lexically_normal();
  std::string name =
      folder.has_filename() ? folder.filename().string() : folder.parent_path().filename().string();
  for (char& c : name) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
    if (!is_plain) c = '-';
  }
  return "evaluate-" + name;
}

// A shipped target by its name, any other by its place, wherever the study is read again.
std::string target_of(const std::string& name_or_path) {
  const fs::path file = find_target_file(name_or_path);
  return fs::path(name_or_path) == file ? fs::absolute(file).lexically_normal().string()
                                        : name_or_path;
}

// The study that the command line asks for, as a file would say it.
std::string study_text(const EvaluateArguments& a) {
  const std::string name = name_of(a.dataset);
  const std::string set = name.substr(name.find('-') + 1);
  std::vector<std::string> solvers;
  for (const std::string& solver : a.solvers) solvers.push_back(toml_text(solver));
  std::string text = fmt::format("name = {}\n", toml_text(name));
  text += fmt::format("title = {}\n", toml_text("Features and pose on the images of " + set));
  text += fmt::format("question = {}\n",
                      toml_text(fmt::format("How well do these solvers do on {}?", set)));
  text += fmt::format("target = {}\n", toml_text(target_of(a.target)));
  text += fmt::format("solvers = [{}]\n", fmt::join(solvers, ", "));
  text += fmt::format("[dataset]\npath = {}\naxes = {}\n",
                      toml_text(fs::absolute(a.dataset).lexically_normal().string()),
                      toml_text(a.axes));
  if (!a.split.empty()) text += fmt::format("split = {}\n", toml_text(a.split));
  if (!a.sensor.empty()) text += fmt::format("sensor = {}\n", toml_text(a.sensor));
  if (a.object) text += fmt::format("object = {}\n", *a.object);
  if (a.prior != kDrawnPrior) {
    text +=
        fmt::format("priors = {}\n", toml_text(fs::absolute(a.prior).lexically_normal().string()));
  }
  return text;
}

int run_evaluate(const EvaluateArguments& arguments, const std::string& command) {
  remember_interrupts();
  const Study study =
      read_study_text(study_text(arguments), "evaluate", overrides_of(arguments.run));
  const ImageStudy* const images = study.images();
  if (images != nullptr && images->sighted) {
    for (const std::string& note : images->sighted->set->notes) {
      std::cerr << "sightline: " << in_one_line(note) << "\n";
    }
  }
  return run_command(study, arguments.run, arguments.run.out, command);
}

}  // namespace

void add_evaluate(CLI::App& app, const std::string& command, int& exit_code) {
  auto arguments = std::make_shared<EvaluateArguments>();
  CLI::App* sub = app.add_subcommand(
      "evaluate",
      "Extract, solve and report on an existing image set, in BOP's format or SPEED+'s");
  sub->add_option("dataset", arguments->dataset,
                  "Folder of the set: BOP's scenes, or SPEED+'s list, images/ and camera.json")
      ->required();
  sub->add_option(
         "--target", arguments->target,
         "Name of a target or its target.toml: the mesh that the images show and its features, or "
         "keypoints alone")
      ->required();
  CLI::Option* out =
      sub->add_option("--out", arguments->run.out, "Folder for the results")->required();
  sub->add_option("--split", arguments->split,
                  "BOP: folder of scenes [test, or the only test*]; SPEED+: the list, such as "
                  "train or lightbox/test [the only one]");
  sub->add_option("--sensor", arguments->sensor,
                  "BOP: the camera of a scene that has several, by the name behind scene_gt_ [that "
                  "which BOP evaluates]");
  sub->add_option("--object", arguments->object, "BOP: obj_id of the target [the only one]");
  sub->add_option("--axes", arguments->axes,
                  "What the set's poses are of: the target's frame (x forward, y starboard, z "
                  "down), as `render` writes them, or the axes of the mesh file that target.toml "
                  "names, where that file is the set's own model")
      ->check(CLI::IsMember({"target", "file"}))
      ->capture_default_str();
  sub->add_option("--prior", arguments->prior,
                  "Where to look: the true pose with an error drawn by --set prior.attitude_deg=2, "
                  "prior.range_percent=1, prior.lateral_px=3 (standard deviations), or a BOP "
                  "results CSV of anyone's poses, mm (SPEED+: scene_id 0, im_id the place in the "
                  "list from 0, obj_id 1); an instance without one there is a failed trial")
      ->capture_default_str();
  sub->add_option("--solvers", arguments->solvers, "Comma-separated (`sightline list solvers`)")
      ->delimiter(',')
      ->capture_default_str();
  sub->add_option("--trials", arguments->run.overrides.trials, "Only the first of the instances");
  sub->add_option("--set", arguments->run.overrides.set,
                  "key=value of a study, for example extraction.passes=2; may be repeated")
      ->allow_extra_args(false);
  add_guest_options(*sub, arguments->run.guests);
  add_run_options(*sub, out, arguments->run);
  sub->callback(
      [arguments, command, &exit_code] { exit_code = run_evaluate(*arguments, command); });
}

}  // namespace sightline
