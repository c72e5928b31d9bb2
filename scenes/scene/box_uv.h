// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Texture coordinates of a box, in metres, for surfaces whose file has none.
#pragma once

#include <vector>

#include "scenes/mesh/mesh.h"

namespace sightline {

/// By part: no picture can lie on it by the coordinates that the file has, if any.
std::vector<bool> parts_without_uv(const Mesh& mesh);

/// Gives the parts that `is_boxed` names metres along the two axes across the one that each
/// triangle faces. Their own textures are then those of the point that all of the part had; of a
/// part with several points they are left out, with the light that it sends by them.
/// The mesh has a coat for each triangle.
void lay_box_uv(const std::vector<bool>& is_boxed, Mesh& mesh);

}  // namespace sightline
