// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "scenes/mesh/material.h"

namespace sightline {

/// A texture with all its smaller versions, each half as large as the one before (area means in
/// linear light, rounded to the texture's own 8 bits), to be looked up at any size.
class TexturePyramid {
 public:
  /// `weighs_alpha`: colours are means by alpha, so that what is not there gives no colour; else
  /// alpha counts for nothing. The texture is kept.
  TexturePyramid(std::shared_ptr<const Texture> texture, bool weighs_alpha);

  /// Linear red, green, blue and alpha at texture coordinates (u, v), bilinear within a level and
  /// linear between two; a level below 0 is magnified.
  Eigen::Array4f at(const TextureRef& ref, float u, float v, float level) const;

  int width() const { return levels_.front().width; }
  int height() const { return levels_.front().height; }

 private:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<uint8_t> own;       // of all levels but the first
    const uint8_t* rgba = nullptr;  // rows of four
  };

  Level halved(const Level& level) const;
  Eigen::Array4f nearest(const Level& level, const TextureRef& ref, float u, float v) const;
  Eigen::Array4f bilinear(const Level& level, const TextureRef& ref, float u, float v) const;
  void add(const uint8_t* texel, float weight, Eigen::Array4f& sum) const;
  Eigen::Array4f unweighed(Eigen::Array4f sum) const;

  std::shared_ptr<const Texture> texture_;
  bool weighs_alpha_;
  const float* linear_;  // of each of the 256 numbers of a colour
  const float* alpha_;   // of those of alpha
  std::vector<Level> levels_;
};

/// The pyramids of a renderer, made when they are first asked for.
class TextureCache {
 public:
  const TexturePyramid& pyramid(const std::shared_ptr<const Texture>& texture, bool weighs_alpha);

 private:
  std::map<std::pair<const Texture*, bool>, std::unique_ptr<TexturePyramid>> pyramids_;
};

}  // namespace sightline
