// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/mesh_options.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "scenes/files/toml_text.h"

namespace sightline {

void add_mesh_options(CLI::App& sub, MeshUse& use) {
  sub.add_option("--forward", use.forward,
                 "For a mesh file: its axis that points forward, x to -z [x]");
  sub.add_option("--up", use.up, "For a mesh file: its axis that points up [-z]");
  sub.add_option("--unit", use.unit,
                 "For a mesh file: its unit, m, cm, mm, km, in, ft or metres as a number [m]");
  sub.add_option("--hide", use.hidden,
                 "Leave a part of the mesh out, such as a propeller's disc; * stands for any "
                 "letters; may be repeated")
      ->allow_extra_args(false);
  sub.add_option("--backfaces", use.backfaces,
                 "Whether surfaces of one side are seen from behind too: material, as the file "
                 "says, or seen [material]")
      ->check(CLI::IsMember({"material", "seen"}));
}

std::vector<std::string> mesh_settings(const MeshUse& use) {
  std::vector<std::string> settings;
  const auto add = [&settings](const char* key, const std::string& value) {
    if (!value.empty()) settings.push_back(fmt::format("mesh.{}={}", key, toml_text(value)));
  };
  add("unit", use.unit);
  add("forward", use.forward);
  add("up", use.up);
  add("backfaces", use.backfaces);
  std::string hidden;
  for (const std::string& part : use.hidden) hidden += toml_text(part) + ", ";
  if (!hidden.empty()) settings.push_back(fmt::format("mesh.hide=[{}]", hidden));
  return settings;
}

}  // namespace sightline
