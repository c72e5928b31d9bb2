// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The loops over a pixel's samples that look textures up, in plain arrays: compiled for several
// levels of the processor (pose/multiversion.h), with the same numbers on each. Samples of a pixel
// lie together, those of one triangle (a group) beside each other: where the texture lies is found
// group by group, and what it shows for all of them at once.
#pragma once

#include <array>
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
  bool is_nearest = false;  ///< read as the texel that a point lies in, unblended

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

/// How a texture lies on a surface.
struct TexelMap {
  bool is_weighed = false;  ///< the levels' colours are factored by alpha; what comes out is not
  Border border_u = Border::kRepeat;
  Border border_v = Border::kRepeat;
  float from_uv[6] = {1, 0, 0, 0, 1, 0};  ///< two rows of three: the texture's coordinates
};

/// Linear red, green, blue and alpha at a point: bilinear within a level, and of two levels the
/// mean, where `share` is the coarse one's. That one is not read where its share is 0.
void look_up(const TexelMap& map, const TexelLevel& fine, const TexelLevel& coarse, float share,
             float u, float v, float* rgba);

/// A value that is linear over a triangle, as the image shows it: a ratio of linear functions of a
/// sample's offset, `at` that of the group's anchor.
struct Carried {
  float at = 0;
  float by_x = 0;  ///< of the numerator, which is that less `at` times the weight
  float by_y = 0;
};

/// Samples of one pixel that see the same triangle.
struct PaintedGroup {
  int count = 0;
  float anchor_x = 0, anchor_y = 0;        ///< where in the pixel, px
  float weight_by_x = 0, weight_by_y = 0;  ///< of the denominator, which is 1 at the anchor
  Carried u, v;
  float least_u = 0, greatest_u = 0, least_v = 0, greatest_v = 0;
  Carried colours[4];  ///< of the corners: red, green, blue, alpha
  TexelLevel base, emission;
};

/// Numbers of a sample's light: four factors on the colour, and what comes without it.
constexpr int kLightNumbers = 8;
/// Arrays by samples are as much longer than there are samples.
constexpr int kSpareSamples = 8;
constexpr int kMostSamples = 256;

/// Something of each sample; what is beyond them is anything.
template <typename Number>
using BySample = std::array<Number, kMostSamples + kSpareSamples>;

/// What is known of samples before textures are looked up.
struct PlacedSamples {
  /// The sizes of the levels that samples read, and 1 where they blend texels.
  struct Levels {
    BySample<int32_t> width{}, height{};
    BySample<float> blend{};
  };

  BySample<float> u{}, v{};  ///< of the corners
  std::array<BySample<float>, 4> colours{};
  BySample<int32_t> group{};
  BySample<int32_t> light{};  ///< whose light it has: a sample's
  Levels base, emission;
};

/// Samples of one pixel that see the same paint, group by group.
struct PaintedSamples {
  const PaintedGroup* groups = nullptr;
  int group_count = 0;
  int count = 0;             ///< of samples
  const float* x = nullptr;  ///< where in the pixel, px: the first group's samples, the second's...
  const float* y = nullptr;
  const float* light = nullptr;        ///< of the samples
  bool has_light_each = false;         ///< else a group's first sample has that of all
  bool has_colours = false;            ///< the corners' count
  const TexelMap* base = nullptr;      ///< none: white
  const TexelMap* emission = nullptr;  ///< none: white
  const float* emitted = nullptr;      ///< four factors on it
  PlacedSamples* placed = nullptr;
};

/// Takes the next of the groups in: finds where its samples see the texture. The sooner before they
/// are lit the better: what has just been written piece by piece, a processor cannot read at once.
void place_group(PaintedSamples& samples);

/// Adds up the light of the samples, each clipped at white: red, green, blue and a fourth number.
void add_painted(const PaintedSamples& samples, float* sum);

/// The light of each sample, clipped at white, and the fourth number: four numbers each.
void paint_each(const PaintedSamples& samples, float* light);

}  // namespace sightline
