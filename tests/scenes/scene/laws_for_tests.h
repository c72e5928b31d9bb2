// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "scenes/scene/scene_law.h"
#include "scenes/target/target.h"
#include "tests/scenes/error_text.h"

namespace sightline {

/// A scene file of the cube, the tables to be added.
inline const std::string kCubeScene = R"(
[camera]
f_px = 4000
[poses]
attitude = "uniform"
lateral_m = [-0.2, 0.2]
range_m = [20, 30]
)";

/// The law of a cube's scene file with more in it; throws InputError.
inline SceneLaw law_of(const std::string& more) {
  const TomlTable table = TomlTable::read_text(kCubeScene + more, "scene.toml");
  const SceneLaw law = read_scene_law(table, load_target("cube"), {0, 1, 2});
  table.reject_unknown_keys();
  return law;
}

/// What is wrong with that file; empty where nothing is.
inline std::string law_error(const std::string& more) {
  return error_of([&] { law_of(more); });
}

}  // namespace sightline
