// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The loops over a pixel's samples that look textures up, in plain arrays: compiled for several
// levels of the processor (pose/multiversion.h), with the same numbers on each.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sightline {

/// A level of a texture: texels of linear red, green, blue and alpha, 65535 is 1. They lie in
/// columns of 8 texels' width, one below the other: a row of a column is a line of the processor's
/// cache, and what a pixel's samples see lies on few pages of memory.
struct TexelLevel {
  const uint16_t* texels = nullptr;
  int width = 0;
  int height = 0;

  static constexpr int kColumnBits = 3;
  static constexpr int kColumn = 1 << kColumnBits;
  /// Where a texel's four numbers begin.
  static ptrdiff_t place(int x, int y, int height) {
    return 4 * (static_cast<ptrdiff_t>(x / kColumn) * height * kColumn +
                static_cast<ptrdiff_t>(y) * kColumn + x % kColumn);
  }
  /// Numbers of a level of this size.
  static size_t numbers(int width, int height) {
    return size_t{4} * ((width + kColumn - 1) / kColumn) * kColumn * height;
  }
};

/// What lies beyond the borders of a texture: Wrap, for files that must not include Eigen.
enum class Border : uint8_t { kRepeat, kMirror, kClamp };

/// How a texture is looked up: bilinear within a level and linear between two.
struct TexelLookup {
  TexelLevel fine;
  TexelLevel coarse;         ///< read where towards_coarse > 0
  float towards_coarse = 0;  ///< its share
  bool is_nearest = false;   ///< the texel of `fine` that a point lies in, unblended
  bool is_weighed = false;   ///< the levels' colours are factored by alpha; what comes out is not
  Border border_u = Border::kRepeat;
  Border border_v = Border::kRepeat;
  float from_uv[6] = {1, 0, 0, 0, 1, 0};  ///< two rows of three: the texture's coordinates
};

/// Linear red, green, blue and alpha at a point.
void look_up(const TexelLookup& lookup, float u, float v, float* rgba);

/// A value that is linear over a triangle, as the image shows it: a ratio of linear functions of a
/// sample's offset, `at` that of the group's anchor.
struct Carried {
  float at = 0;
  float by_x = 0;  ///< of the numerator, which is that less `at` times the weight
  float by_y = 0;
};

/// Samples of one pixel that see the same triangle.
struct PaintedSamples {
  const float* x = nullptr;  ///< offsets from the anchor, px
  const float* y = nullptr;
  int count = 0;          ///< at most kMostSamples
  float weight_by_x = 0;  ///< of the denominator, which is 1 at the anchor
  float weight_by_y = 0;
  Carried u, v;
  float least_u = 0, greatest_u = 0, least_v = 0, greatest_v = 0;
  bool has_colours = false;
  Carried colours[4];                     ///< of the corners: red, green, blue, alpha
  const TexelLookup* base = nullptr;      ///< none: white
  const TexelLookup* emission = nullptr;  ///< none: white
  float emitted[4] = {0, 0, 0, 0};        ///< factors on it
  /// Factors on the colour, and light that comes without it: four numbers a sample or, where
  /// light_step is 0, for all.
  const float* of_base = nullptr;
  const float* own = nullptr;
  int light_step = 0;
};

/// Adds up the light of the samples, each clipped at white: red, green, blue and a fourth number.
void add_painted(const PaintedSamples& samples, float* sum);

/// The light of each sample, clipped at white, and the fourth number: four numbers each.
void paint_each(const PaintedSamples& samples, float* light);

/// Texture coordinates of the samples.
void uv_of(const PaintedSamples& samples, float* u, float* v);

}  // namespace sightline
