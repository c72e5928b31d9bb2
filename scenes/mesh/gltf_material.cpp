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

#include "scenes/mesh/gltf_accessor.h"
#include "scenes/mesh/gltf_uri.h"

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

// The image of a texture; -1 where it has none that is read.
int source_of(const tinygltf::Texture& texture) {
  const auto* webp = extension(texture.extensions, "EXT_texture_webp");
  return webp == nullptr ? texture.source
                         : static_cast<int>(number_of(*webp, "source", texture.source));
}

std::string name_of(const tinygltf::Image& image, int index) {
  if (!image.uri.empty()) return path_of_uri(image.uri);
  return image.name.empty() ? fmt::format("(image {})", index)
                            : fmt::format("{} (image {})", image.name, index);
}

// Why a texture without an image that is read has none.
std::string why_no_image(const tinygltf::Texture& texture) {
  if (texture.extensions.empty()) return "names no image of the file";
  const std::string& extension = texture.extensions.begin()->first;
  const char* const format = extension == "KHR_texture_basisu" ? "KTX 2, "
                             : extension == "MSFT_texture_dds" ? "DDS, "
                             : extension == "EXT_texture_avif" ? "AVIF, "
                                                               : "";
  return fmt::format("is in a format that is not read ({}{})", format, extension);
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

TextureRef GltfMaterials::reference(int material, const char* what,
                                    const tinygltf::TextureInfo& info, bool is_srgb) {
  TextureRef ref;
  if (info.index < 0) return ref;
  const std::string& name = model_.materials[material].name;
  const std::string whose = name.empty() ? fmt::format("material {}", material) : name;
  if (info.index >= static_cast<int>(model_.textures.size())) {
    fail_gltf(file_, fmt::format("the {} texture of {} is number {}, but it has {}", what, whose,
                                 info.index, model_.textures.size()));
  }
  if (uv_set_of(info) != uv_set(material)) {
    left_out_.insert(fmt::format("the {} texture of {}", what, whose));
    return ref;
  }
  const tinygltf::Texture& texture = model_.textures[info.index];
  const int source = source_of(texture);
  if (source >= 0 && source < static_cast<int>(model_.images.size())) {
    const tinygltf::Image& image = model_.images[source];
    ref.texture =
        shelf_.from_bytes({reinterpret_cast<const char*>(image.image.data()), image.image.size()},
                          name_of(image, source), is_srgb);
  } else {
    ref.texture = shelf_.lose(fmt::format("number {}", info.index), why_no_image(texture));
  }
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

Material GltfMaterials::material(int index) {
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
  to.base_texture = reference(index, "base", base_texture_of(from), true);
  to.gloss_texture = reference(index, "gloss", pbr.metallicRoughnessTexture, false);
  to.emissive_texture = reference(index, "emissive", from.emissiveTexture, true);
  to.normal_texture = reference(index, "normal", info_of(from.normalTexture), false);
  to.normal_scale = std::clamp(from.normalTexture.scale, -1e3, 1e3);
  to.occlusion_texture = reference(index, "occlusion", info_of(from.occlusionTexture), false);
  to.occlusion_strength = within_unit(from.occlusionTexture.strength);
  return to;
}

}  // namespace sightline
