// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "scenes/target/mesh_use.h"

namespace CLI {
class App;
}  // namespace CLI

namespace sightline {

/// Adds --unit, --forward, --up and --hide, which say how a mesh is taken.
void add_mesh_options(CLI::App& sub, MeshUse& use);

/// The same as settings over a study's or scene's file: its table [mesh].
std::vector<std::string> mesh_settings(const MeshUse& use);

}  // namespace sightline
