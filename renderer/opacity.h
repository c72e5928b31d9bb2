// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "renderer/shading.h"
#include "renderer/texture.h"
#include "scenes/mesh/material.h"

namespace sightline {

/// How much of what is behind it a surface of this alpha covers, as glTF says: a mask all or
/// nothing, a blend as much as its alpha says, what is opaque all.
float opacity(AlphaMode mode, double cutoff, float alpha);

/// The opacity of bodies' surfaces at single points.
class SurfaceOpacity {
 public:
  /// Without textures the factors of the materials alone count.
  SurfaceOpacity(const std::vector<PlacedBody>& bodies, bool draws_textures,
                 TextureCache& textures);

  /// Where the ray (x/z, y/z) meets the triangle of an id; textures are looked up in full size.
  float at(uint32_t id, const Eigen::Vector2d& normalised);

 private:
  float alpha_at(const Mesh& mesh, const Material& material, const SurfacePoint& point);

  const std::vector<PlacedBody>& bodies_;
  std::vector<RayHits> hits_;
  bool draws_textures_;
  TextureCache& textures_;
};

}  // namespace sightline
