// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "eval/output/json.h"
#include "scenes/mesh/mesh.h"

namespace sightline {

/// A mesh as binary PLY in millimetres, in its target's frame: float vertices, triangles.
std::string ply_bytes(const Mesh& mesh);

/// BOP's models_info of the vertices as the PLY has them: diameter (the greatest distance of two),
/// min_x, ... and size_x, ..., millimetres.
Json model_info(const Mesh& mesh);

}  // namespace sightline
