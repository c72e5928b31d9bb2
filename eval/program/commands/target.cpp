// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "eval/output/plain_text.h"
#include "eval/output/terminal.h"
#include "eval/program/commands/commands.h"
#include "eval/program/mesh_options.h"
#include "eval/review/target_review.h"
#include "eval/target/target_edit.h"
#include "eval/target/target_report.h"

namespace sightline {

namespace {

// What is done to a target's features, beside looking at it.
struct TargetChanges {
  TargetEdits edits;
  std::string review;  // the page to write; none if empty
  bool is_json = false;
};

void run_target(const TargetArguments& arguments, const TargetChanges& changes) {
  if (changes.is_json) {
    std::cout << target_json(arguments.target, arguments.mesh);
    return;
  }
  std::string told;
  const bool is_proposal = arguments.propose.has_value();
  if (!is_proposal && !changes.edits.empty()) told = edit_target(arguments.target, changes.edits);
  const TargetReport report = report_target(arguments);
  std::cout << shown(report.text);
  const std::string file = is_proposal ? report.proposed.string() : arguments.target;
  if (is_proposal && !changes.edits.empty()) told = edit_target(file, changes.edits);
  if (!told.empty()) std::cout << '\n' << told;
  if (changes.review.empty()) return;
  write_review(file, changes.review);
  std::cout << "\nreview     " << plain_line(changes.review) << '\n';
}

}  // namespace

void add_target(CLI::App& app) {
  auto arguments = std::make_shared<TargetArguments>();
  CLI::App* sub = app.add_subcommand(
      "target", "Say what a mesh or a target holds: size, parts, closedness, edges, features");
  sub->add_option("target", arguments->target, "Name of a target, a target.toml or a mesh file")
      ->required();
  add_mesh_options(*sub, arguments->mesh);
  CLI::Option* picture =
      sub->add_option("--picture", arguments->picture,
                      "Also draw it into this .png, in colour where its mesh has any");
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
  CLI::Option* decimate =
      sub->add_option("--decimate", arguments->kept_percent,
                      "Also write the mesh with this percentage of its triangles, to --out")
          ->check(CLI::Range(0.001, 100.0));
  CLI::Option* out =
      sub->add_option("--out", arguments->coarser, "The .glb of --decimate")->needs(decimate);
  decimate->needs(out);
  auto changes = std::make_shared<TargetChanges>();
  CLI::Option* drop =
      sub->add_option("--drop", changes->edits.dropped,
                      "Take features of these names out of the target.toml, or the proposal")
          ->expected(1, 1000);
  CLI::Option* add =
      sub->add_option(
             "--add", changes->edits.added,
             "Add a contour feature at x,y,z or x,y,z,NAME to it (metres, the target's frame)")
          ->expected(1, 1000);
  CLI::Option* review = sub->add_option(
      "--review", changes->review,
      "Write a page to judge the features by into this .html: pictures from six sides, "
      "from where each is to be seen, how well it is found");
  CLI::Option* json = sub->add_flag("--json", changes->is_json, "Print JSON instead of the tables");
  CLI::Option* const theta = sub->get_option("--theta");
  for (CLI::Option* other : {picture, theta, propose, decimate, drop, add, review}) {
    json->excludes(other);
  }
  sub->callback([arguments, changes] { run_target(*arguments, *changes); });
}

}  // namespace sightline
