// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "renderer/paint_kernel.h"
#include "scenes/mesh/material.h"

namespace sightline {

/// A texture with all its smaller versions, each half as large as the one before (area means), in
/// linear light of 16 bits, to be looked up at any size.
class TexturePyramid {
 public:
  /// `weighs_alpha`: colours are means by alpha, so that what is not there gives no colour; else
  /// alpha counts for nothing.
  TexturePyramid(const Texture& texture, bool weighs_alpha);

  /// Linear red, green, blue and alpha at texture coordinates (u, v), bilinear within a level and
  /// linear between two; a level below 0 is magnified.
  Eigen::Array4f at(const TextureRef& ref, float u, float v, float level) const;

  /// How the texture lies on a surface.
  TexelMap map(const TextureRef& ref) const;
  /// A level to be read alone; those below 0 are the finest, magnified.
  TexelLevel level(const TextureRef& ref, int level) const;

  int width() const { return levels_.front().width; }
  int height() const { return levels_.front().height; }

 private:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<uint16_t> texels;  // as TexelLevel has them, factored by alpha if it counts

    TexelLevel view() const { return {texels.data(), width, height}; }
    uint16_t* texel(int x, int y) { return texels.data() + TexelLevel::place(x, y, height); }
  };

  bool weighs_alpha_;
  std::vector<Level> levels_;

  static Level first_level(const Texture& texture, bool weighs_alpha);
  static Level halved(Level& level);
};

/// The pyramids of a renderer, made when they are first asked for, and let go once nobody holds
/// their textures any more and another is made.
class TextureCache {
 public:
  /// Valid as long as somebody holds the texture.
  const TexturePyramid& pyramid(const std::shared_ptr<const Texture>& texture, bool weighs_alpha);

 private:
  // Two of a texture: alpha counts for nothing, or is weighed.
  using Pyramids = std::array<std::unique_ptr<TexturePyramid>, 2>;
  std::map<std::weak_ptr<const Texture>, Pyramids, std::owner_less<>> pyramids_;
};

}  // namespace sightline
