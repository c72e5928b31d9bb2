// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/paint_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "pose/multiversion.h"

namespace sightline {
namespace {

// Samples go by eights, written as vectors. Vectors are handed on by reference: how they travel by
// value depends on the processor.
constexpr int kLanes = 8;
using Floats = float __attribute__((vector_size(32)));
using Ints = int32_t __attribute__((vector_size(32)));
// Two texels beside each other.
using Codes = uint16_t __attribute__((vector_size(16)));
// One.
using Floats4 = float __attribute__((vector_size(16)));

constexpr float kWhite = 65535;
constexpr float kFarOut = 1e9f;  // fits an integer

// A NaN becomes the least.
inline void clamp(Floats& value, float least, float greatest) {
  const Floats low = Floats{} + least;
  const Floats high = Floats{} + greatest;
  value = value > low ? value : low;
  value = value < high ? value : high;
}

// The largest whole numbers that are not greater.
inline void find_floor(const Floats& value, Ints& whole, Floats& floor) {
  whole = __builtin_convertvector(value, Ints);
  floor = __builtin_convertvector(whole, Floats);
  const Ints is_above = floor > value;  // -1 where it is
  whole += is_above;
  floor += __builtin_convertvector(is_above, Floats);
}

// Coordinates come to lie within [0, 1].
inline void wrap_all(Floats& coordinates, Border border) {
  clamp(coordinates, -kFarOut, kFarOut);
  Ints whole;
  Floats floor;
  if (border == Border::kRepeat) {
    find_floor(coordinates, whole, floor);
    coordinates -= floor;
  } else if (border == Border::kMirror) {
    find_floor(coordinates / 2, whole, floor);
    const Floats folded = coordinates - 2 * floor;
    coordinates = folded <= 1 ? folded : 2 - folded;
  }
  clamp(coordinates, 0, 1);
}

// Where the two texels about a coordinate lie, and how much the second of them counts.
struct Place {
  Ints first, second;
  Floats share;
};

// Indices of texels.
inline void find_places(const Floats& coordinates, int texels, Border border, Place& place) {
  // Beyond the border by one at most.
  const Ints before = Ints{} + (border == Border::kRepeat ? texels - 1 : 0);
  const Ints after = Ints{} + (border == Border::kRepeat ? 0 : texels - 1);
  const Floats at = coordinates * static_cast<float>(texels) - 0.5f;
  Ints first;
  Floats floor;
  find_floor(at, first, floor);
  place.share = at - floor;
  place.second = first + 1 >= texels ? after : first + 1;
  place.first = first < 0 ? before : first;
}

// Columns' indices as numbers from the level's begin, and rows' as numbers from the column's.
inline void columns_to_numbers(Ints& columns, int height) {
  constexpr int kBits = TexelLevel::kColumnBits;
  columns = 4 * (columns + (((columns >> kBits) * (height - 1)) << kBits));
}

inline void rows_to_numbers(Ints& rows) {
  rows = rows * (4 * TexelLevel::kColumn);
}

// Adds the blend of two texels of a row, still apart.
inline void add_row(const uint16_t* row, int first, int second, const Floats& weights,
                    Floats& sum) {
  Codes codes;
  if (second == first + 4) {
    std::memcpy(&codes, row + first, sizeof(codes));
  } else {
    uint64_t texels[2];
    std::memcpy(&texels[0], row + first, sizeof(texels[0]));
    std::memcpy(&texels[1], row + second, sizeof(texels[1]));
    std::memcpy(&codes, texels, sizeof(codes));
  }
  sum += weights * __builtin_convertvector(__builtin_convertvector(codes, Ints), Floats);
}

inline void add_level(const TexelLevel& level, const TexelLookup& lookup, float weight,
                      const Floats& u, const Floats& v, int count, Floats (&sums)[kLanes]) {
  Place columns, rows;
  find_places(u, level.width, lookup.border_u, columns);
  find_places(v, level.height, lookup.border_v, rows);
  columns_to_numbers(columns.first, level.height);
  columns_to_numbers(columns.second, level.height);
  rows_to_numbers(rows.first);
  rows_to_numbers(rows.second);
  const Floats right = weight * columns.share;
  const Floats left = weight - right;
  for (int k = 0; k < count; ++k) {
    const Floats shares = {left[k],  left[k],  left[k],  left[k],
                           right[k], right[k], right[k], right[k]};
    const Floats lower = shares * rows.share[k];
    const int first = columns.first[k];
    const int second = columns.second[k];
    add_row(level.texels + rows.first[k], first, second, shares - lower, sums[k]);
    add_row(level.texels + rows.second[k], first, second, lower, sums[k]);
  }
}

inline void read_nearest(const TexelLookup& lookup, const Floats& u, const Floats& v, int count,
                         Floats4 (&rgba)[kLanes]) {
  const TexelLevel& level = lookup.fine;
  for (int k = 0; k < count; ++k) {
    const int x = static_cast<int>(u[k] * static_cast<float>(level.width));
    const int y = static_cast<int>(v[k] * static_cast<float>(level.height));
    const uint16_t* texel =
        level.texels + TexelLevel::place(std::min(x, level.width - 1),
                                         std::min(y, level.height - 1), level.height);
    for (int c = 0; c < 4; ++c) rgba[k][c] = static_cast<float>(texel[c]) / kWhite;
  }
}

inline void read_blended(const TexelLookup& lookup, const Floats& u, const Floats& v, int count,
                         Floats4 (&rgba)[kLanes]) {
  Floats sums[kLanes];
  for (int k = 0; k < count; ++k) sums[k] = Floats{};
  const float coarse = lookup.towards_coarse;
  add_level(lookup.fine, lookup, 1 - coarse, u, v, count, sums);
  if (coarse > 0) add_level(lookup.coarse, lookup, coarse, u, v, count, sums);
  for (int k = 0; k < count; ++k) {
    Floats4 halves[2];
    std::memcpy(halves, &sums[k], sizeof(halves));
    rgba[k] = (halves[0] + halves[1]) / kWhite;
  }
}

inline void look_up_lanes(const TexelLookup& lookup, const Floats& u, const Floats& v, int count,
                          Floats4 (&rgba)[kLanes]) {
  const float* m = lookup.from_uv;
  Floats across = m[0] * u + m[1] * v + m[2];
  Floats down = m[3] * u + m[4] * v + m[5];
  wrap_all(across, lookup.border_u);
  wrap_all(down, lookup.border_v);
  if (lookup.is_nearest) {
    read_nearest(lookup, across, down, count, rgba);
  } else {
    read_blended(lookup, across, down, count, rgba);
  }
  if (!lookup.is_weighed) return;
  for (int k = 0; k < count; ++k) {
    const float alpha = rgba[k][3];
    if (alpha > 0) rgba[k] /= alpha;
    rgba[k][3] = alpha;
  }
}

// Eight samples of a group, or fewer.
struct Eight {
  int count;
  Floats x, y, per_weight;
};

inline void find_eight(const PaintedSamples& s, int begin, Eight& eight) {
  eight.count = std::min(kLanes, s.count - begin);
  eight.x = Floats{};
  eight.y = Floats{};
  for (int k = 0; k < eight.count; ++k) {
    eight.x[k] = s.x[begin + k];
    eight.y[k] = s.y[begin + k];
  }
  eight.per_weight = 1 / (1 + s.weight_by_x * eight.x + s.weight_by_y * eight.y);
}

inline void carry(const Carried& value, const Eight& eight, float least, float greatest,
                  Floats& out) {
  out = value.at + (value.by_x * eight.x + value.by_y * eight.y) * eight.per_weight;
  clamp(out, least, greatest);
}

// A sample of a lens's chords may lie off the triangle by some 1e-4 px, much seen edge-on.
inline void carry_uv(const PaintedSamples& s, const Eight& eight, Floats& u, Floats& v) {
  carry(s.u, eight, s.least_u, s.greatest_u, u);
  carry(s.v, eight, s.least_v, s.greatest_v, v);
}

inline void load(const float* from, Floats4& four) {
  std::memcpy(&four, from, sizeof(four));
}

// The base colour without its factor.
inline void colour(const PaintedSamples& s, const Eight& eight, const Floats& u, const Floats& v,
                   Floats4 (&colours)[kLanes]) {
  if (s.base != nullptr) {
    look_up_lanes(*s.base, u, v, eight.count, colours);
  } else {
    for (Floats4& white : colours) white = Floats4{1, 1, 1, 1};
  }
  if (!s.has_colours) return;
  for (int c = 0; c < 4; ++c) {
    Floats values;
    carry(s.colours[c], eight, 0, 1, values);
    for (int k = 0; k < eight.count; ++k) colours[k][c] *= values[k];
  }
}

// Finds the light of eight samples, clipped at white.
inline void light_eight(const PaintedSamples& s, int begin, int& count, Floats4 (&lights)[kLanes]) {
  Floats4 of_base, own, emitted;
  load(s.emitted, emitted);
  const Floats4 white = {1, 1, 1, 1};
  Eight eight;
  find_eight(s, begin, eight);
  count = eight.count;
  Floats u, v;
  carry_uv(s, eight, u, v);
  Floats4 colours[kLanes], emission[kLanes];
  colour(s, eight, u, v, colours);
  if (s.emission != nullptr) look_up_lanes(*s.emission, u, v, count, emission);
  for (int k = 0; k < count; ++k) {
    const ptrdiff_t at = static_cast<ptrdiff_t>(begin + k) * s.light_step;
    load(s.of_base + at, of_base);
    load(s.own + at, own);
    Floats4 light = of_base * colours[k] + own;
    if (s.emission != nullptr) light += emitted * emission[k];
    lights[k] = light < white ? light : white;
  }
}

SIGHTLINE_MULTIVERSION
void add_all(const PaintedSamples& s, float* sum) {
  Floats4 total;
  load(sum, total);
  for (int begin = 0; begin < s.count; begin += kLanes) {
    Floats4 lights[kLanes];
    int count = 0;
    light_eight(s, begin, count, lights);
    for (int k = 0; k < count; ++k) total += lights[k];
  }
  std::memcpy(sum, &total, sizeof(total));
}

SIGHTLINE_MULTIVERSION
void paint_all_samples(const PaintedSamples& s, float* light) {
  for (int begin = 0; begin < s.count; begin += kLanes) {
    Floats4 lights[kLanes];
    int count = 0;
    light_eight(s, begin, count, lights);
    std::memcpy(light + 4 * begin, lights, sizeof(Floats4) * static_cast<size_t>(count));
  }
}

SIGHTLINE_MULTIVERSION
void look_up_one(const TexelLookup& lookup, float u, float v, float* rgba) {
  Floats4 texels[kLanes];
  look_up_lanes(lookup, Floats{} + u, Floats{} + v, 1, texels);
  std::memcpy(rgba, &texels[0], sizeof(texels[0]));
}

}  // namespace

void look_up(const TexelLookup& lookup, float u, float v, float* rgba) {
  look_up_one(lookup, u, v, rgba);
}

void add_painted(const PaintedSamples& samples, float* sum) {
  add_all(samples, sum);
}

void paint_each(const PaintedSamples& samples, float* light) {
  paint_all_samples(samples, light);
}

void uv_of(const PaintedSamples& samples, float* u, float* v) {
  for (int begin = 0; begin < samples.count; begin += kLanes) {
    Eight eight;
    find_eight(samples, begin, eight);
    Floats all_u, all_v;
    carry_uv(samples, eight, all_u, all_v);
    for (int k = 0; k < eight.count; ++k) {
      u[begin + k] = all_u[k];
      v[begin + k] = all_v[k];
    }
  }
}

}  // namespace sightline
