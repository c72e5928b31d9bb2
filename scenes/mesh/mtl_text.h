// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The materials of Wavefront .obj files as text. Assimp skips the options of their pictures, and
// loses a picture's name behind options that are shorter than it expects.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

/// A picture of a material. A corner's coordinates times `scale` plus `offset` are those in the
/// picture, whose lower left corner is (0, 0).
struct MtlMap {
  std::string file;
  std::array<double, 2> scale{1, 1};
  std::array<double, 2> offset{0, 0};
  bool is_clamped = false;
};

struct MtlMaterial {
  std::optional<MtlMap> colour;    ///< map_Kd
  std::optional<MtlMap> emission;  ///< map_Ke
  std::optional<MtlMap> alpha;     ///< map_d
};

/// The materials of a .mtl by their names; of two alike the first.
std::map<std::string, MtlMaterial> mtl_materials(std::string_view mtl);

/// The files of materials that an .obj names.
std::vector<std::string> mtl_files(std::string_view obj);

}  // namespace sightline
