// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "scenes/mesh/material.h"
#include "scenes/mesh/textures.h"

namespace tinygltf {
class Model;
struct TextureInfo;
}  // namespace tinygltf

namespace sightline {

/// Turns the materials of a glTF file into ours, and its images into textures.
///
/// Read are the metallic-roughness model with base colour, metallic-roughness, emissive, normal and
/// occlusion texture, samplers, alpha modes, double-sidedness, and the extensions
/// KHR_materials_unlit, KHR_materials_emissive_strength, KHR_texture_transform, EXT_texture_webp
/// and the diffuse half of KHR_materials_pbrSpecularGlossiness. The images' bytes must be in the
/// model as they are in their files.
class GltfMaterials {
 public:
  GltfMaterials(const tinygltf::Model& model, const std::filesystem::path& file,
                TextureShelf& shelf)
      : model_(model), file_(file), shelf_(shelf) {}

  /// The material of that index, which must exist. All its textures take the set of coordinates of
  /// the first of them that is there; those of another set are left out. Throws InputError where it
  /// names a texture that the file does not have.
  Material material(int index);
  /// The set of texture coordinates that a material takes: 0 for TEXCOORD_0.
  int uv_set(int index) const;

  /// The textures that were left out so far, as "the normal texture of paint".
  const std::set<std::string>& left_out() const { return left_out_; }

 private:
  TextureRef reference(int material, const char* what, const tinygltf::TextureInfo& info,
                       bool is_srgb);

  const tinygltf::Model& model_;
  const std::filesystem::path& file_;
  TextureShelf& shelf_;
  std::set<std::string> left_out_;
};

}  // namespace sightline
