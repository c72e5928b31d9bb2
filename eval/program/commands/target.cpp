// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "eval/program/commands/commands.h"
#include "eval/program/mesh_options.h"
#include "eval/target/target_report.h"

namespace sightline {

void add_target(CLI::App& app) {
  auto arguments = std::make_shared<TargetArguments>();
  CLI::App* sub = app.add_subcommand(
      "target", "Say what a mesh or a target holds: size, parts, closedness, edges, features");
  sub->add_option("target", arguments->target, "Name of a target, a target.toml or a mesh file")
      ->required();
  add_mesh_options(*sub, arguments->mesh);
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
  CLI::Option* decimate =
      sub->add_option("--decimate", arguments->kept_percent,
                      "Also write the mesh with this percentage of its triangles, to --out")
          ->check(CLI::Range(0.001, 100.0));
  CLI::Option* out =
      sub->add_option("--out", arguments->coarser, "The .glb of --decimate")->needs(decimate);
  decimate->needs(out);
  sub->callback([arguments] { std::cout << report_target(*arguments); });
}

}  // namespace sightline
