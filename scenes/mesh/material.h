// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a mesh's file says of its surfaces beside their shape. Grey pictures without textures take
// Part::albedo alone; colour ones take all of this.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sightline {

/// A picture that lies on a surface: rows of red, green, blue, alpha, 8 bits each, top row first.
struct Texture {
  std::string name;  ///< of its file, or of its place in the mesh's file
  int width = 0;
  int height = 0;
  bool is_srgb = true;  ///< its colours are encoded as IEC 61966-2-1 says; alpha never is
  std::vector<uint8_t> rgba;
};

/// What lies beyond the borders of a texture.
enum class Wrap : uint8_t { kRepeat, kMirror, kClamp };

/// A texture as a material uses it. Texture coordinates (0, 0) are the upper left corner of the
/// first texel, (1, 1) the lower right one of the last.
struct TextureRef {
  int texture = -1;  ///< index into Mesh::textures; -1: there is none
  Wrap wrap_u = Wrap::kRepeat;
  Wrap wrap_v = Wrap::kRepeat;
  bool is_nearest = false;  ///< magnified texels are squares, not blends
  /// Two rows of three: the texture's coordinates from the corners'.
  std::array<double, 6> texture_from_uv{1, 0, 0, 0, 1, 0};

  bool is_there() const { return texture >= 0; }
};

/// How a fragment's alpha decides whether it is there.
enum class AlphaMode : uint8_t { kOpaque, kMask, kBlend };

constexpr double kLargestEmission = 1000;  ///< of a channel, 1 is white

/// A surface as glTF 2.0 describes it; linear, 1 is white.
struct Material {
  std::array<double, 4> base{1, 1, 1, 1};  ///< factor on base_texture and the corners' colours
  /// False: dull after Lambert, with the light's own highlights, whatever the next two say.
  bool has_gloss = false;
  double metallic = 0;
  double roughness = 1;
  bool is_unlit = false;  ///< its base colour is the light that it sends
  std::array<double, 3> emissive{0, 0, 0};
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  double alpha_cutoff = 0.5;  ///< of kMask: what has less is not there
  bool is_two_sided = true;   ///< false: it is there from outside alone, where its normals point
  TextureRef base_texture;
  TextureRef gloss_texture;  ///< green is the factor on roughness, blue that on metallic
  TextureRef emissive_texture;
  TextureRef normal_texture;      ///< tilts the normal: x along the texture's u, y against its v
  double normal_scale = 1;        ///< factor on the tilt
  TextureRef occlusion_texture;   ///< red is the share of the light from all around that arrives
  double occlusion_strength = 1;  ///< 0 to 1: how much of that is taken: 1 + strength (red - 1)

  std::array<TextureRef*, 5> textures() {
    return {&base_texture, &gloss_texture, &emissive_texture, &normal_texture, &occlusion_texture};
  }
};

/// What a triangle's corners carry for its material.
struct Coat {
  std::array<Eigen::Vector2f, 3> uv{Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero(),
                                    Eigen::Vector2f::Zero()};
  /// Linear red, green, blue and alpha, factors on the material's.
  std::array<Eigen::Vector4f, 3> colour{Eigen::Vector4f::Ones(), Eigen::Vector4f::Ones(),
                                        Eigen::Vector4f::Ones()};
};

}  // namespace sightline
