// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "renderer/colour_shading.h"
#include "renderer/sample_pattern.h"
#include "renderer/screen.h"
#include "renderer/shading.h"
#include "scenes/scene/scene.h"

namespace sightline {

/// Turns what samples see into coloured light: a surface is lit once a pixel, at the sample nearest
/// to the pixel's centre that sees it, and its texture is looked up at every sample, at the level
/// of detail where the samples of a pixel, spread along the longer axis of its footprint, just meet
/// (the shorter axis in texels over the root of their number). Stripes, shadows and the highlights
/// of dull surfaces are those of every sample, as in grey.
class ColourResolver {
 public:
  /// All but the bodies' shadows must outlive it.
  ColourResolver(const std::vector<PlacedBody>& bodies, const Scene& scene, const Screen& screen,
                 const SamplePattern& pattern, TextureCache& textures);

  /// The mean of one pixel's samples, each clipped at white; where they see nothing it is
  /// `background`. Linear red, green, blue.
  Eigen::Array3f mean(int x, int y, const uint32_t* ids, const Eigen::Array3f& background);

 private:
  // A triangle as this pixel sees it.
  struct Seen {
    uint32_t id = 0;
    int triangle = 0;
    const ColourShader* shader = nullptr;
    bool is_painted = false;
    bool has_colours = false;
    bool is_plain = false;  // every sample of it is alike
    bool emits = false;
    float level = 0;  // of the texture
    // What its corners carry: at the centre, by x and by y of the offset.
    Eigen::Matrix<double, 3, 3> uv;       // u, v, weight
    Eigen::Matrix<double, 4, 3> colours;  // red, green, blue, alpha, by the same weight
    Eigen::Vector2d least_uv, greatest_uv;
    ColourLight light;
    Eigen::Array3f factor;
    Eigen::Array3f plain;
  };
  struct PaintPoint {
    Eigen::Vector2f uv = Eigen::Vector2f::Zero();
    Eigen::Array3f colour = Eigen::Array3f::Ones();
  };

  void enter_pixel(int x, int y);
  const Seen& entry_of(uint32_t id, int sample);
  void meet(uint32_t id, int sample, Seen& seen);
  void carry(Seen& seen, int sample);
  const CarriedValues& carried_by(uint32_t id, const ColourShader& shader, int triangle);
  PaintPoint paint_at(const Seen& seen, int sample) const;
  ColourLight light_at(const Seen& seen, int sample, const PaintPoint& paint) const;
  Eigen::Array3f light_of(const Seen& seen, const ColourLight& light,
                          const PaintPoint& paint) const;

  const std::vector<PlacedBody>& bodies_;
  const Camera& camera_;
  const Screen& screen_;
  const SamplePattern& pattern_;
  std::vector<ColourShader> shaders_;
  std::unordered_map<uint32_t, CarriedValues> carried_;
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();     // of the pixel, normalised
  Eigen::Matrix2d per_pixel_ = Eigen::Matrix2d::Zero();  // its derivative by the pixel
  float sample_levels_;  // how many levels finer a sample is than a pixel
  std::vector<Seen> seen_;
  size_t known_ = 0;  // entries of seen_
  size_t last_ = 0;   // the one found last
};

/// How a body is shadowed; none where the scene's light casts no shadows.
std::unique_ptr<const ShadowMap> shadow_on(const std::vector<PlacedBody>& bodies, size_t body,
                                           const Scene& scene);

}  // namespace sightline
