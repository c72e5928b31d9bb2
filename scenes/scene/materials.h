// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Surfaces other than those of the meshes' files, drawn for each frame: the keys of [material].
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenes/scene/colouring.h"
#include "scenes/scene/file_draw.h"
#include "scenes/scene/keys.h"
#include "scenes/scene/others.h"
#include "scenes/target/target.h"

namespace sightline {

/// What was drawn for a body, or for one of its parts. What has no value is the part's own.
struct DrawnMaterial {
  int body = 0;      ///< 0 is the main target, others follow in their order
  std::string part;  ///< its name; empty: the whole body
  int part_index = -1;
  std::optional<std::array<double, 3>> base;  ///< linear red, green, blue
  std::optional<double> roughness;
  std::optional<double> metallic;
  std::optional<double> emission;
  std::string texture;   ///< the picture's file; empty: the part's own
  double texture_m = 0;  ///< the width of a picture on a surface without texture coordinates
};

/// A body that materials are drawn for.
struct DressedBody {
  std::shared_ptr<const Target> target;    ///< as it is seen without
  std::shared_ptr<const Target> prepared;  ///< with texture coordinates where parts need them
  std::vector<bool> has_box_uv;            ///< by part: these are of a box, in metres
  double side_m = 0;                       ///< the longest of its mesh's box
};

class FileTextures;

/// What a file says of them.
struct MaterialLaw {
  bool has_colour = false;  ///< one of the next three is given
  Range hue_deg{0, 360};
  Range saturation = 0;
  Range value = Part{}.albedo;
  std::optional<Range> roughness;
  std::optional<Range> metallic;
  std::optional<Range> emission;
  std::string textures;  ///< as it was given; empty: there are none
  std::optional<Range> texture_m;
  bool is_per_part = false;
  bool is_of_all = false;  ///< of the bodies beside the main target too
  FileDraw files = {};     ///< the pictures of `textures`; of one picture that alone
  std::vector<DressedBody> bodies = {};
  std::shared_ptr<FileTextures> shelf = {};

  bool is_there() const;
};

std::vector<Key> keys_of(MaterialLaw& law);

/// Reads the keys, and makes texture coordinates for the bodies that have none. Throws InputError.
MaterialLaw read_materials(const TomlTable& file, const ColouringLaw& colouring,
                           const std::shared_ptr<const Target>& target,
                           const std::vector<OtherLaw>& others);

/// Draws materials, and has the bodies wear them: `target` and the targets of `others` become
/// copies with other parts. Nothing happens where the file has no such keys. Throws InputError for
/// a picture that cannot be read.
std::vector<DrawnMaterial> dress(const MaterialLaw& law, const Draws& draws,
                                 std::shared_ptr<const Target>& target,
                                 std::vector<OtherBody>& others);

/// Reads the pictures that one scene draws, unless `checked` has them already. Throws InputError.
void check_drawn_files(const MaterialLaw& law, const Draws& draws, CheckedFiles& checked);

/// What the truth states of one.
std::vector<Fact> facts_of(const DrawnMaterial& drawn);

}  // namespace sightline
