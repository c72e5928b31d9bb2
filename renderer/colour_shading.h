// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "renderer/brdf.h"
#include "renderer/shading.h"
#include "renderer/texture.h"
#include "scenes/scene/colouring.h"

namespace sightline {

/// Where rays through a pixel's neighbourhood meet a triangle, in terms of what its corners carry:
/// linear functions of the ray (x/z, y/z, 1), whose ratios to the weight are the carried values.
struct CarriedValues {
  Eigen::Matrix3d uv;                   ///< u, v, weight
  Eigen::Matrix<double, 4, 3> colours;  ///< red, green, blue, alpha
  Eigen::Vector2d least_uv, greatest_uv;
};

/// Light by channel: a factor on the base colour, and what comes without it.
struct ColourLight {
  Eigen::Array3f of_base = Eigen::Array3f::Zero();
  Eigen::Array3f own = Eigen::Array3f::Zero();

  void add(const Reflection& light, const Eigen::Array3f& colour) {
    of_base += static_cast<float>(light.of_base) * colour;
    own += static_cast<float>(light.own) * colour;
  }
};

/// What one body sends to the camera, by channel. Where the scene is grey the surfaces are dull
/// ones of their base colour, as Shader has them; in colour those with gloss follow brdf.h. The
/// ambient light is a glow from all sides, and the highlights of [light] are those of the dull.
class ColourShader {
 public:
  ColourShader(const PlacedBody& body, const Light& light, bool is_grey, bool draws_textures,
               std::unique_ptr<const ShadowMap> shadow, TextureCache& textures);

  /// The light at a point. `uv` and `level` are where textures of the part are looked up that say
  /// how it is reflected.
  ColourLight light_at(const SurfacePoint& point, const Eigen::Vector2f& uv, float level) const;
  /// The texture's colour (linear, with alpha) at texture coordinates `uv`; white without one.
  Eigen::Array4f texel_at(int triangle, const Eigen::Vector2f& uv, float level) const;
  /// Light of its own, in colour alone.
  Eigen::Array3f emission_at(int triangle, const Eigen::Vector2f& uv, float level) const;

  /// The texture whose levels of detail are counted, the base colour's where there is one; null
  /// where the triangle has none. Levels of the others are turned to their own size.
  const TextureRef* finest_texture(int triangle) const;
  /// Its sides in texels.
  Eigen::Vector2d texels(int triangle) const;

  /// The triangle's corners carry something that its part draws.
  bool is_painted(int triangle) const { return paints_[part_of(triangle)].is_painted; }
  /// They carry colours that are not all white.
  bool has_colours(int triangle) const { return paints_[part_of(triangle)].has_colours; }
  /// The factor on the texture's colour.
  const Eigen::Array4f& base_factor(int triangle) const {
    return paints_[part_of(triangle)].factor;
  }
  bool emits(int triangle) const { return paints_[part_of(triangle)].emits; }
  CarriedValues carried(int triangle) const;

  const RayHits& hits() const { return hits_; }
  /// As in Shader: each sample wants its own light.
  bool has_detail() const;

 private:
  struct Paint {
    Material material;
    Eigen::Array4f factor = Eigen::Array4f::Ones();
    bool is_painted = false;
    bool has_colours = false;
    bool emits = false;
    const TexturePyramid* base = nullptr;
    const TexturePyramid* gloss = nullptr;
    const TexturePyramid* emissive = nullptr;
    const TexturePyramid* normal = nullptr;
    // The one that counts levels, and how many levels coarser the others are.
    const TexturePyramid* first = nullptr;
    const TextureRef* first_ref = nullptr;
    float gloss_shift = 0;
    float emissive_shift = 0;
    float normal_shift = 0;
  };

  int part_of(int triangle) const { return hits_.body().mesh->triangles[triangle].part; }
  Paint paint_of(const Part& part, bool draws_textures, TextureCache& textures) const;
  static void count_levels(Paint& paint);
  void find_colours();
  Eigen::Vector3d tilted(const Paint& paint, int triangle, const Eigen::Vector3d& normal,
                         const Eigen::Vector2f& uv, float level) const;
  Reflection of_distant(const Paint& paint, const Gloss& gloss, double level,
                        const Eigen::Vector3d& to_light, const Eigen::Vector3d& normal,
                        const Eigen::Vector3d& to_eye) const;
  Gloss gloss_at(const Paint& paint, const Eigen::Vector2f& uv, float level) const;
  double stripe_at(const Eigen::Vector3d& x) const;

  RayHits hits_;
  Light light_;
  bool is_grey_;
  Eigen::Vector3d to_light_;  // body's frame
  Eigen::Vector3d to_second_;
  Eigen::Array3f colour_, second_colour_;  // white where the scene is grey
  Eigen::Matrix3d body_from_cam_;
  std::unique_ptr<const ShadowMap> shadow_;
  std::vector<Paint> paints_;  // a part each
};

}  // namespace sightline
