// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Writes the targets that Sightline builds itself: sightline_build_targets assets/targets
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include "scenes/builders/boeing707.h"
#include "scenes/builders/boeing707_livery.h"
#include "scenes/builders/cube.h"
#include "scenes/builders/tango.h"
#include "scenes/files/input_error.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: sightline_build_targets DIR\n");
    return 2;
  }
  try {
    const std::filesystem::path folder = argv[1];
    for (const sightline::BuiltTarget& target :
         {sightline::build_boeing707_target(), sightline::build_boeing707_livery_target(),
          sightline::build_cube(), sightline::build_tango()}) {
      sightline::write_target(target, folder / target.name);
      fmt::print("{}: {} triangles, {} features\n", (folder / target.name).string(),
                 target.mesh.triangles.size(), target.features.size());
    }
  } catch (const sightline::InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
