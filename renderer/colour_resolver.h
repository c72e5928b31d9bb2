// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "renderer/colour_shading.h"
#include "renderer/environment.h"
#include "renderer/open_sky.h"
#include "renderer/sample_pattern.h"
#include "renderer/screen.h"
#include "renderer/shading.h"
#include "scenes/scene/scene.h"

namespace sightline {

/// What a renderer keeps between pictures: textures, skies, and memory.
struct ColourMemory {
  TextureCache textures;
  SkyMemory skies;
  std::unique_ptr<EnvironmentLight> environment;  ///< of the last scene that had one
  std::vector<int> plane_index;  ///< by id, one more than its place in planes; 0: not yet made
  std::vector<SurfacePlane> planes;

  /// That of the scene, made where it is another than the last; none where the scene has none.
  EnvironmentLight* environment_of(const Scene& scene);
};

/// Turns what samples see into coloured light: a surface is lit once a pixel, at the sample nearest
/// to the pixel's centre that sees it, and its texture is looked up at every sample, at the level
/// of detail where the samples of a pixel, spread along the longer axis of its footprint, just meet
/// (the shorter axis in texels over the root of their number). Stripes, shadows and the highlights
/// of dull surfaces are those of every sample, as in grey.
class ColourResolver {
 public:
  /// All but the bodies' shadows must outlive it.
  ColourResolver(const std::vector<PlacedBody>& bodies, const Scene& scene, const Screen& screen,
                 const SamplePattern& pattern, ColourMemory& memory);

  /// The mean of one pixel's samples, each clipped at white; where they see nothing it is
  /// `background`. Linear red, green, blue.
  Eigen::Array3f mean(int x, int y, const uint32_t* ids, const Eigen::Array3f& background);

  /// Some surface shows what is behind: then pixels are made of layers, the nearest first. Alpha is
  /// that of glTF: a mask's surface is there where it reaches the cutoff, a blend lets 1 - alpha of
  /// what is behind through.
  bool is_see_through() const;
  /// Adds what `ids` see behind the layers before to the pixel's samples, four numbers each: light,
  /// and the part that is let through, which begin as 0, 0, 0, 1. `nearness` becomes -FLT_MAX where
  /// nothing is let through. True when something is.
  bool add_layer(int x, int y, const uint32_t* ids, float* nearness, Eigen::Array4f* samples);
  /// The mean of samples that layers have been added to.
  Eigen::Array3f mean(const Eigen::Array4f* samples, const Eigen::Array3f& background) const;

 private:
  // The samples of a pixel that see one triangle, the nearest to the pixel's centre first.
  struct Group {
    uint32_t id = 0;
    int begin = 0;  // in order_
    int count = 0;
  };
  // Samples, and where in a pixel they are, px.
  struct Order {
    std::vector<int> sample;
    std::vector<float> x, y;
  };
  struct Surface {
    const ColourShader& shader;
    const Paint& paint;
    int triangle;
  };

  void enter_pixel(int x, int y);
  void group(const uint32_t* ids);
  int first_sample(const Group& group) const;
  Eigen::Vector3d ray_of(int sample) const;
  Surface surface_of(const Group& group) const;
  const SurfacePlane& plane_of(uint32_t id, const Surface& surface);
  void light_group(const Group& group, const Surface& surface, PaintedSamples& run);
  void light_samples(const Group& group, const Surface& surface, const SurfacePlane& plane,
                     size_t place, float level, float sky);
  float anchor(const Group& group, const SurfacePlane& plane, const Paint& paint,
               const Eigen::Vector3d& ray, PaintedGroup& painted) const;
  Eigen::Array4f flat_light(const Group& group, const Surface& surface, int sample) const;
  void add_flat(const Group& group, const Surface& surface, Eigen::Array4f& sum) const;
  PaintedSamples empty_run(const Surface& surface, const Group& first);
  size_t add_run(size_t first, Eigen::Array4f& sum);

  const std::vector<PlacedBody>& bodies_;
  const Camera& camera_;
  const Screen& screen_;
  const SamplePattern& pattern_;
  std::vector<ColourShader> shaders_;
  ColourMemory& memory_;
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();     // of the pixel, normalised
  Eigen::Matrix2d per_pixel_ = Eigen::Matrix2d::Zero();  // its derivative by the pixel
  std::vector<Group> groups_;
  size_t known_ = 0;  // entries of groups_
  Order as_drawn_, by_group_;
  const Order* order_ = &as_drawn_;    // of the pixel's samples
  std::vector<int> rest_;              // samples whose groups are not yet known
  std::vector<float> light_;           // of each group's samples, as PaintedSamples have it
  std::vector<PaintedGroup> run_;      // groups of one paint, one after the other
  PlacedSamples placed_;               // of those
  std::vector<Eigen::Array4f> layer_;  // of a group's samples: light and alpha
};

/// How a body is shadowed; none where the scene's light casts no shadows.
std::unique_ptr<const Shadow> shadow_on(const std::vector<PlacedBody>& bodies, size_t body,
                                        const Scene& scene);

}  // namespace sightline
