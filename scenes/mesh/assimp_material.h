// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <initializer_list>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scenes/mesh/mesh.h"
#include "scenes/mesh/mtl_text.h"
#include "scenes/mesh/textures.h"

struct aiMaterial;
struct aiMesh;
struct aiScene;

namespace sightline {

/// Turns the materials of a file that Assimp has read into ours: colour, opacity and emission with
/// their pictures. Of an .obj, `mtl` says how the pictures lie.
class AssimpMaterials {
 public:
  AssimpMaterials(const aiScene& scene, std::map<std::string, MtlMaterial> mtl,
                  TextureShelf& shelf);

  /// A part of that name for a mesh; grey and dull ones have no material.
  Part part(const aiMesh& mesh, std::string name);

  /// What of the materials so far is not drawn, or is taken otherwise than the file says; clauses.
  std::vector<std::string> notes() const;

 private:
  // A picture as a material names it; without a file where it names none.
  struct Picture {
    std::string file;
    TextureRef ref;
  };
  struct Pictures {
    Picture colour, emission, alpha;
    bool any() const {
      return !colour.file.empty() || !emission.file.empty() || !alpha.file.empty();
    }
  };
  static Picture picture_of(const aiMaterial& material, std::initializer_list<int> types);
  static Picture picture_of(const MtlMap& map);
  Pictures pictures_of(const aiMaterial& material) const;
  int texture_index(const std::string& path, bool is_srgb);
  void add_textures(const Pictures& pictures, Material& to);

  const aiScene& scene_;
  std::map<std::string, MtlMaterial> mtl_;
  TextureShelf& shelf_;
  // All materials are wholly clear, as exporters write it that take 0 for opaque.
  bool is_clear_for_opaque_ = false;
  // By colours and the file of the opacity: no picture is read twice for what is there already.
  std::map<std::pair<int, std::string>, std::pair<int, AlphaMode>> cut_;
  std::set<std::string> without_coordinates_;  // parts with pictures
  std::set<std::string> moved_;                // pictures of opacity that lie as the colour does
};

}  // namespace sightline
