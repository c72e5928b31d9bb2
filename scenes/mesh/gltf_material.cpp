// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/gltf_material.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

// As mesh_gltf.cpp has it, which holds the library's code.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

namespace sightline {
namespace {

constexpr const char* kOurs = "sightline";

double number_of(const tinygltf::Value& object, const char* key, double fallback) {
  if (!object.Has(key) || !object.Get(key).IsNumber()) return fallback;
  const double value = object.Get(key).GetNumberAsDouble();
  return std::isfinite(value) ? value : fallback;
}

double number_of(const tinygltf::Value& object, const char* key, size_t i, double fallback) {
  if (!object.Has(key) || !object.Get(key).IsArray() || object.Get(key).ArrayLen() <= i) {
    return fallback;
  }
  const tinygltf::Value& value = object.Get(key).Get(i);
  return value.IsNumber() ? value.GetNumberAsDouble() : fallback;
}

const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const char* name) {
  const auto found = extensions.find(name);
  return found == extensions.end() ? nullptr : &found->second;
}

double within_unit(double value) {
  return value > 0 ? std::min(value, 1.0) : 0.0;
}

Wrap wrap_of(int gltf) {
  if (gltf == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::kClamp;
  return gltf == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::kMirror : Wrap::kRepeat;
}

// KHR_texture_transform: translation times rotation times scale.
std::array<double, 6> transform_of(const tinygltf::Value& extension) {
  const double angle = number_of(extension, "rotation", 0);
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const double across = number_of(extension, "scale", 0, 1);
  const double down = number_of(extension, "scale", 1, 1);
  return {c * across,  s * down, number_of(extension, "offset", 0, 0),
          -s * across, c * down, number_of(extension, "offset", 1, 0)};
}

const tinygltf::Value* transform_extension(const tinygltf::TextureInfo& info) {
  return extension(info.extensions, "KHR_texture_transform");
}

int uv_set_of(const tinygltf::TextureInfo& info) {
  const tinygltf::Value* transform = transform_extension(info);
  return transform == nullptr ? info.texCoord
                              : static_cast<int>(number_of(*transform, "texCoord", info.texCoord));
}

// The same by another type.
template <typename Info>
tinygltf::TextureInfo info_of(const Info& special) {
  tinygltf::TextureInfo info;
  info.index = special.index;
  info.texCoord = special.texCoord;
  info.extensions = special.extensions;
  return info;
}

// The base colour texture of the model that came before metallic-roughness, as that one has it.
tinygltf::TextureInfo diffuse_texture(const tinygltf::Value& specular_glossiness) {
  tinygltf::TextureInfo info;
  if (!specular_glossiness.Has("diffuseTexture")) return info;
  const tinygltf::Value& texture = specular_glossiness.Get("diffuseTexture");
  info.index = static_cast<int>(number_of(texture, "index", -1));
  info.texCoord = static_cast<int>(number_of(texture, "texCoord", 0));
  return info;
}

const tinygltf::Value* specular_glossiness_of(const tinygltf::Material& material) {
  return extension(material.extensions, "KHR_materials_pbrSpecularGlossiness");
}

tinygltf::TextureInfo base_texture_of(const tinygltf::Material& material) {
  const tinygltf::Value* older = specular_glossiness_of(material);
  const tinygltf::TextureInfo& newer = material.pbrMetallicRoughness.baseColorTexture;
  return older != nullptr && newer.index < 0 ? diffuse_texture(*older) : newer;
}

void set_base(const tinygltf::Material& from, Material& to) {
  const auto& factor = from.pbrMetallicRoughness.baseColorFactor;
  const tinygltf::Value* older = specular_glossiness_of(from);
  for (size_t i = 0; i < to.base.size(); ++i) {
    const double given = i < factor.size() ? factor[i] : 1;
    to.base[i] = within_unit(older == nullptr ? given : number_of(*older, "diffuseFactor", i, 1));
  }
}

// Files of ours say by no metal at full roughness that a surface is dull.
bool is_dull(const tinygltf::Model& model, const Material& material) {
  return model.asset.generator == kOurs && material.metallic == 0 && material.roughness == 1;
}

void set_emission(const tinygltf::Material& from, Material& to) {
  const tinygltf::Value* strength = extension(from.extensions, "KHR_materials_emissive_strength");
  const double factor =
      strength == nullptr ? 1 : std::max(0.0, number_of(*strength, "emissiveStrength", 1));
  for (size_t i = 0; i < std::min(to.emissive.size(), from.emissiveFactor.size()); ++i) {
    to.emissive[i] = std::min(kLargestEmission, factor * within_unit(from.emissiveFactor[i]));
  }
}

}  // namespace

int GltfMaterials::uv_set(int index) const {
  const tinygltf::Material& from = model_.materials[index];
  for (const tinygltf::TextureInfo& info :
       {base_texture_of(from), from.pbrMetallicRoughness.metallicRoughnessTexture,
        from.emissiveTexture, info_of(from.normalTexture), info_of(from.occlusionTexture)}) {
    if (info.index >= 0) return uv_set_of(info);
  }
  return 0;
}

TextureRef GltfMaterials::reference(const tinygltf::TextureInfo& info, int uv_set,
                                    bool is_srgb) const {
  TextureRef ref;
  const bool is_there = info.index >= 0 && info.index < static_cast<int>(model_.textures.size()) &&
                        uv_set_of(info) == uv_set;
  if (!is_there) return ref;
  const tinygltf::Texture& texture = model_.textures[info.index];
  int source = texture.source;
  if (const auto* webp = extension(texture.extensions, "EXT_texture_webp")) {
    source = static_cast<int>(number_of(*webp, "source", source));
  }
  const bool has_image = source >= 0 && source < static_cast<int>(model_.images.size());
  std::string name = fmt::format("number {}", info.index);
  std::string_view bytes;
  if (has_image) {
    const tinygltf::Image& image = model_.images[source];
    bytes = {reinterpret_cast<const char*>(image.image.data()), image.image.size()};
    name = !image.uri.empty()    ? image.uri
           : !image.name.empty() ? fmt::format("{} (image {})", image.name, source)
                                 : fmt::format("(image {})", source);
  }
  ref.texture = shelf_.from_bytes(bytes, name, is_srgb);
  if (const tinygltf::Value* transform = transform_extension(info)) {
    ref.texture_from_uv = transform_of(*transform);
  }
  if (texture.sampler >= 0 && texture.sampler < static_cast<int>(model_.samplers.size())) {
    const tinygltf::Sampler& sampler = model_.samplers[texture.sampler];
    ref.wrap_u = wrap_of(sampler.wrapS);
    ref.wrap_v = wrap_of(sampler.wrapT);
    ref.is_nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
  }
  return ref;
}

Material GltfMaterials::material(int index) const {
  const tinygltf::Material& from = model_.materials[index];
  const tinygltf::PbrMetallicRoughness& pbr = from.pbrMetallicRoughness;
  Material to;
  set_base(from, to);
  set_emission(from, to);
  to.metallic = within_unit(pbr.metallicFactor);
  to.roughness = within_unit(pbr.roughnessFactor);
  to.has_gloss = specular_glossiness_of(from) == nullptr && !is_dull(model_, to);
  to.is_unlit = extension(from.extensions, "KHR_materials_unlit") != nullptr;
  to.alpha_mode = from.alphaMode == "MASK"    ? AlphaMode::kMask
                  : from.alphaMode == "BLEND" ? AlphaMode::kBlend
                                              : AlphaMode::kOpaque;
  to.alpha_cutoff = std::max(0.0, std::min(from.alphaCutoff, 1e6));
  to.is_two_sided = from.doubleSided;
  const int set = uv_set(index);
  to.base_texture = reference(base_texture_of(from), set, true);
  to.gloss_texture = reference(pbr.metallicRoughnessTexture, set, false);
  to.emissive_texture = reference(from.emissiveTexture, set, true);
  to.normal_texture = reference(info_of(from.normalTexture), set, false);
  to.normal_scale = std::clamp(from.normalTexture.scale, -1e3, 1e3);
  to.occlusion_texture = reference(info_of(from.occlusionTexture), set, false);
  to.occlusion_strength = within_unit(from.occlusionTexture.strength);
  return to;
}

}  // namespace sightline
