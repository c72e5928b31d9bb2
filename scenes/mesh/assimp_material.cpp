// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/assimp_material.h"

#include <algorithm>
#include <utility>

#include <assimp/material.h>
#include <assimp/mesh.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include "scenes/mesh/mesh_soup.h"
#include "scenes/mesh/mesh_text.h"

namespace sightline {
namespace {

Wrap wrap_of(const aiMaterial& material, const char* key, unsigned type, unsigned index) {
  int mode = aiTextureMapMode_Wrap;
  material.Get(key, type, index, mode);
  if (mode == aiTextureMapMode_Mirror) return Wrap::kMirror;
  return mode == aiTextureMapMode_Clamp ? Wrap::kClamp : Wrap::kRepeat;
}

// A colour of nothing beside a texture means that the texture is the colour.
aiColor3D diffuse_of(const aiMaterial* material, bool has_texture) {
  aiColor3D diffuse(0.8f, 0.8f, 0.8f);
  if (material != nullptr) material->Get(AI_MATKEY_COLOR_DIFFUSE, diffuse);
  if (has_texture && diffuse.IsBlack()) diffuse = aiColor3D(1, 1, 1);
  return diffuse;
}

aiColor3D emission_of(const aiMaterial* material, bool has_texture) {
  aiColor3D emission(0, 0, 0);
  if (material != nullptr) material->Get(AI_MATKEY_COLOR_EMISSIVE, emission);
  if (has_texture && emission.IsBlack()) emission = aiColor3D(1, 1, 1);
  return emission;
}

double emission(float channel) {
  return channel > 0 ? std::min<double>(channel, kLargestEmission) : 0;
}

double stated_opacity(const aiMaterial& material) {
  float opacity = 1;
  material.Get(AI_MATKEY_OPACITY, opacity);
  return within_unit(opacity);
}

}  // namespace

AssimpMaterials::AssimpMaterials(const aiScene& scene, std::map<std::string, MtlMaterial> mtl,
                                 TextureShelf& shelf)
    : scene_(scene), mtl_(std::move(mtl)), shelf_(shelf) {
  const aiMesh* const* const begin = scene.mMeshes;
  is_clear_for_opaque_ = std::all_of(begin, begin + scene.mNumMeshes, [&](const aiMesh* mesh) {
    return mesh->mMaterialIndex < scene.mNumMaterials &&
           stated_opacity(*scene.mMaterials[mesh->mMaterialIndex]) == 0;
  });
}

// Assimp's coordinates begin at the lower left corner.
AssimpMaterials::Picture AssimpMaterials::picture_of(const aiMaterial& material,
                                                     std::initializer_list<int> types) {
  for (const int number : types) {
    const auto type = static_cast<aiTextureType>(number);
    aiString path;
    if (material.GetTexture(type, 0, &path) != aiReturn_SUCCESS || path.length == 0) continue;
    return {path.C_Str(),
            {.wrap_u = wrap_of(material, AI_MATKEY_MAPPINGMODE_U(type, 0)),
             .wrap_v = wrap_of(material, AI_MATKEY_MAPPINGMODE_V(type, 0)),
             .texture_from_uv = {1, 0, 0, 0, -1, 1}}};
  }
  return {};
}

AssimpMaterials::Picture AssimpMaterials::picture_of(const MtlMap& map) {
  const Wrap wrap = map.is_clamped ? Wrap::kClamp : Wrap::kRepeat;
  return {
      map.file,
      {.wrap_u = wrap,
       .wrap_v = wrap,
       .texture_from_uv = {map.scale[0], 0, map.offset[0], 0, -map.scale[1], 1 - map.offset[1]}}};
}

AssimpMaterials::Pictures AssimpMaterials::pictures_of(const aiMaterial& material) const {
  Pictures out{picture_of(material, {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}),
               picture_of(material, {aiTextureType_EMISSION_COLOR, aiTextureType_EMISSIVE}),
               picture_of(material, {aiTextureType_OPACITY})};
  aiString name;
  material.Get(AI_MATKEY_NAME, name);
  const auto found = mtl_.find(name.C_Str());
  if (found == mtl_.end()) return out;
  const MtlMaterial& mtl = found->second;
  if (mtl.colour) out.colour = picture_of(*mtl.colour);
  if (mtl.emission) out.emission = picture_of(*mtl.emission);
  if (mtl.alpha) out.alpha = picture_of(*mtl.alpha);
  return out;
}

// The index of a texture that a material names: a file, or one within the mesh's file.
int AssimpMaterials::texture_index(const std::string& path, bool is_srgb) {
  const aiTexture* inside = scene_.GetEmbeddedTexture(path.c_str());
  if (inside == nullptr) return shelf_.from_file(path, is_srgb);
  const bool is_encoded = inside->mHeight == 0;  // then the width is its bytes
  const auto* bytes = reinterpret_cast<const char*>(inside->pcData);
  return shelf_.from_bytes({bytes, is_encoded ? inside->mWidth : 0},
                           fmt::format("{} within the file", path), is_srgb);
}

// The pictures of colour, opacity and emission, as far as they can be had.
void AssimpMaterials::add_textures(const Pictures& pictures, Material& to) {
  if (!pictures.colour.file.empty()) {
    to.base_texture = pictures.colour.ref;
    to.base_texture.texture = texture_index(pictures.colour.file, true);
  }
  if (!pictures.emission.file.empty()) {
    to.emissive_texture = pictures.emission.ref;
    to.emissive_texture.texture = texture_index(pictures.emission.file, true);
  }
  if (pictures.alpha.file.empty()) return;
  const bool has_colour = to.base_texture.is_there();
  const std::pair made_of(to.base_texture.texture, pictures.alpha.file);
  if (!cut_.contains(made_of)) {
    const int alpha = pictures.alpha.file == pictures.colour.file
                          ? to.base_texture.texture
                          : texture_index(pictures.alpha.file, false);
    if (alpha < 0) return;
    cut_[made_of] = shelf_.with_alpha(to.base_texture.texture, alpha);
  }
  const auto [texture, mode] = cut_.at(made_of);
  if (!has_colour) to.base_texture = pictures.alpha.ref;
  if (to.base_texture.texture_from_uv != pictures.alpha.ref.texture_from_uv) {
    moved_.insert(pictures.alpha.file);
  }
  to.base_texture.texture = texture;
  if (to.alpha_mode == AlphaMode::kOpaque) to.alpha_mode = mode;
}

Part AssimpMaterials::part(const aiMesh& mesh, std::string name) {
  const aiMaterial* from =
      mesh.mMaterialIndex < scene_.mNumMaterials ? scene_.mMaterials[mesh.mMaterialIndex] : nullptr;
  Pictures pictures;
  if (from != nullptr) pictures = pictures_of(*from);
  if (pictures.any() && !mesh.HasTextureCoords(0)) {
    without_coordinates_.insert(name);
    pictures = {};
  }
  const bool has_texture = !pictures.colour.file.empty();
  const aiColor3D diffuse = diffuse_of(from, has_texture);
  const aiColor3D emitted = emission_of(from, !pictures.emission.file.empty());
  const double opacity = from == nullptr || is_clear_for_opaque_ ? 1 : stated_opacity(*from);
  const double albedo = luminance(diffuse.r, diffuse.g, diffuse.b);
  const bool is_grey = diffuse.r == diffuse.g && diffuse.g == diffuse.b;
  const bool is_plain = is_grey && emitted.IsBlack() && opacity == 1;
  if (is_plain && !pictures.any() && !mesh.HasVertexColors(0)) return {std::move(name), albedo};
  Material material;
  material.base = {within_unit(diffuse.r), within_unit(diffuse.g), within_unit(diffuse.b), opacity};
  if (mesh.HasVertexColors(0) && !has_texture) material.base = {1, 1, 1, opacity};
  material.emissive = {emission(emitted.r), emission(emitted.g), emission(emitted.b)};
  if (opacity < 1) material.alpha_mode = AlphaMode::kBlend;
  add_textures(pictures, material);
  return {std::move(name), albedo, material};
}

std::vector<std::string> AssimpMaterials::notes() const {
  std::vector<std::string> notes;
  if (!without_coordinates_.empty()) {
    notes.push_back(fmt::format("drawn without textures, whose coordinates are not there: {}",
                                listed(without_coordinates_)));
  }
  if (!moved_.empty()) {
    notes.push_back(
        fmt::format("opacity that lies as the colour under it does: {}", listed(moved_)));
  }
  if (is_clear_for_opaque_) {
    notes.emplace_back(
        "all its materials have an opacity of 0, which some exporters write for 1: drawn opaque");
  }
  return notes;
}

}  // namespace sightline
