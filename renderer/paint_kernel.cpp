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
// Two texels.
using Codes = uint16_t __attribute__((vector_size(16)));
// One.
using Floats4 = float __attribute__((vector_size(16)));

constexpr float kOfCode = 1.0f / 65535;
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

// Indices of texels. `blend` is 1, or 0 where the texel that a point lies in counts alone.
inline void find_places(const Floats& coordinates, const Ints& texels, const Floats& blend,
                        Border border, Place& place) {
  const Ints last = texels - 1;
  const Ints repeats = Ints{} - (border == Border::kRepeat ? 1 : 0);
  const Ints before = last & repeats;
  const Ints after = last & ~repeats;
  const Floats at = coordinates * __builtin_convertvector(texels, Floats) - 0.5f * blend;
  Ints first;
  Floats floor;
  find_floor(at, first, floor);
  place.share = (at - floor) * blend;
  // Beyond the border by one at most.
  place.second = first >= last ? after : first + 1;
  first = first > last ? last : first;
  place.first = first < 0 ? before : first;
}

// Columns' indices as numbers from the level's begin, and rows' as numbers from the column's.
inline void columns_to_numbers(Ints& columns, const Ints& height) {
  constexpr int kBits = TexelLevel::kColumnBits;
  columns = 4 * (columns + (((columns >> kBits) * (height - 1)) << kBits));
}

inline void rows_to_numbers(Ints& rows) {
  rows = rows * (4 * TexelLevel::kColumn);
}

using Levels = PlacedSamples::Levels;

template <typename Vector, typename Number>
inline void load(const Number* from, Vector& vector) {
  std::memcpy(&vector, from, sizeof(vector));
}

template <typename Vector, typename Number>
inline void store(const Vector& vector, Number* to) {
  std::memcpy(to, &vector, sizeof(vector));
}

inline void put_level(const TexelLevel& level, int begin, Levels& levels) {
  store(Ints{} + level.width, levels.width.data() + begin);
  store(Ints{} + level.height, levels.height.data() + begin);
  store(Floats{} + (level.is_nearest ? 0.0f : 1.0f), levels.blend.data() + begin);
}

// Where the four texels about each of eight points lie in their levels, and how much each counts.
struct Corners {
  Ints places[4];  // the upper two, the lower two
  Floats weights[4];
};

inline void find_corners(const TexelMap& map, const Levels& levels, int begin, const Floats& u,
                         const Floats& v, Corners& corners) {
  const float* m = map.from_uv;
  Floats across = m[0] * u + m[1] * v + m[2];
  Floats down = m[3] * u + m[4] * v + m[5];
  wrap_all(across, map.border_u);
  wrap_all(down, map.border_v);
  Ints width, height;
  Floats blend;
  load(levels.width.data() + begin, width);
  load(levels.height.data() + begin, height);
  load(levels.blend.data() + begin, blend);
  Place columns, rows;
  find_places(across, width, blend, map.border_u, columns);
  find_places(down, height, blend, map.border_v, rows);
  columns_to_numbers(columns.first, height);
  columns_to_numbers(columns.second, height);
  rows_to_numbers(rows.first);
  rows_to_numbers(rows.second);
  corners.places[0] = rows.first + columns.first;
  corners.places[1] = rows.first + columns.second;
  corners.places[2] = rows.second + columns.first;
  corners.places[3] = rows.second + columns.second;
  const Floats lower = rows.share;
  const Floats upper = 1 - lower;
  corners.weights[1] = upper * columns.share;
  corners.weights[0] = upper - corners.weights[1];
  corners.weights[3] = lower * columns.share;
  corners.weights[2] = lower - corners.weights[3];
}

// Two texels' numbers, each by its weight.
inline void weigh(const uint16_t* first, const uint16_t* second, float of_first, float of_second,
                  Floats& weighed) {
  uint64_t texels[2];
  std::memcpy(&texels[0], first, sizeof(texels[0]));
  std::memcpy(&texels[1], second, sizeof(texels[1]));
  Codes codes;
  std::memcpy(&codes, texels, sizeof(codes));
  const Floats weights = {of_first,  of_first,  of_first,  of_first,
                          of_second, of_second, of_second, of_second};
  weighed = weights * __builtin_convertvector(__builtin_convertvector(codes, Ints), Floats);
}

// `texels` are those of a sample's level, by its place among the eight.
template <typename Texels>
inline void read_lanes(const TexelMap& map, const Levels& levels, const Texels& texels_of,
                       int begin, const Floats& u, const Floats& v, int count,
                       Floats4 (&rgba)[kLanes]) {
  Corners corners;
  find_corners(map, levels, begin, u, v, corners);
  const auto& at = corners.places;
  const auto& weight = corners.weights;
  for (int k = 0; k < count; ++k) {
    const uint16_t* texels = texels_of(k);
    Floats upper, lower;
    weigh(texels + at[0][k], texels + at[1][k], weight[0][k], weight[1][k], upper);
    weigh(texels + at[2][k], texels + at[3][k], weight[2][k], weight[3][k], lower);
    const Floats sum = upper + lower;
    Floats4 halves[2];
    std::memcpy(halves, &sum, sizeof(halves));
    rgba[k] = (halves[0] + halves[1]) * kOfCode;
  }
}

// Of a colour that is factored by alpha.
inline void take_alpha_out(Floats4& rgba) {
  const float alpha = rgba[3];
  if (alpha > 0) rgba /= alpha;
  rgba[3] = alpha;
}

// Offsets of eight samples from a group's anchor, and one over the denominator there.
struct Eight {
  Floats x, y, per_weight;
};

inline void find_eight(const PaintedGroup& group, const float* x, const float* y, Eight& eight) {
  load(x, eight.x);
  load(y, eight.y);
  eight.x -= group.anchor_x;
  eight.y -= group.anchor_y;
  eight.per_weight = 1 / (1 + group.weight_by_x * eight.x + group.weight_by_y * eight.y);
}

inline void carry(const Carried& value, const Eight& eight, float least, float greatest,
                  Floats& out) {
  out = value.at + (value.by_x * eight.x + value.by_y * eight.y) * eight.per_weight;
  clamp(out, least, greatest);
}

// A sample of a lens's chords may lie off the triangle by some 1e-4 px, much seen edge-on.
inline void carry_uv(const PaintedGroup& group, const Eight& eight, Floats& u, Floats& v) {
  carry(group.u, eight, group.least_u, group.greatest_u, u);
  carry(group.v, eight, group.least_v, group.greatest_v, v);
}

// Eights at a time: what is written beyond a group's end is the next one's to write again.
SIGHTLINE_MULTIVERSION
void place_all(PaintedSamples& s) {
  const PaintedGroup& group = s.groups[s.group_count];
  PlacedSamples& placed = *s.placed;
  const Ints counting = {0, 1, 2, 3, 4, 5, 6, 7};
  const int light_step = s.has_light_each ? 1 : 0;
  for (int i = 0; i < group.count; i += kLanes) {
    const int begin = s.count + i;
    Eight eight;
    find_eight(group, s.x + begin, s.y + begin, eight);
    Floats u, v;
    carry_uv(group, eight, u, v);
    store(u, placed.u.data() + begin);
    store(v, placed.v.data() + begin);
    if (s.base != nullptr) put_level(group.base, begin, placed.base);
    if (s.emission != nullptr) put_level(group.emission, begin, placed.emission);
    store(Ints{} + s.group_count, placed.group.data() + begin);
    store(s.count + (i + counting) * light_step, placed.light.data() + begin);
    if (!s.has_colours) continue;
    for (size_t c = 0; c < 4; ++c) {
      Floats values;
      carry(group.colours[c], eight, 0, 1, values);
      store(values, placed.colours[c].data() + begin);
    }
  }
  s.count += group.count;
  ++s.group_count;
}

inline void look_up_lanes(const PaintedSamples& s, const TexelMap& map, const Levels& levels,
                          TexelLevel PaintedGroup::*level, int begin, int count,
                          Floats4 (&rgba)[kLanes]) {
  Floats u, v;
  load(s.placed->u.data() + begin, u);
  load(s.placed->v.data() + begin, v);
  const auto texels = [&](int k) {
    return (s.groups[s.placed->group[static_cast<size_t>(begin + k)]].*level).texels;
  };
  read_lanes(map, levels, texels, begin, u, v, count, rgba);
  if (!map.is_weighed) return;
  for (int k = 0; k < count; ++k) take_alpha_out(rgba[k]);
}

// The base colour without its factor.
inline void find_colours(const PaintedSamples& s, int begin, int count,
                         Floats4 (&colours)[kLanes]) {
  if (s.base != nullptr) {
    look_up_lanes(s, *s.base, s.placed->base, &PaintedGroup::base, begin, count, colours);
  } else {
    for (Floats4& white : colours) white = Floats4{1, 1, 1, 1};
  }
  if (!s.has_colours) return;
  for (int c = 0; c < 4; ++c) {
    const float* of_corners = s.placed->colours[static_cast<size_t>(c)].data() + begin;
    for (int k = 0; k < count; ++k) colours[k][c] *= of_corners[k];
  }
}

// Finds the light of eight samples, clipped at white.
inline void light_eight(const PaintedSamples& s, int begin, int count, Floats4 (&lights)[kLanes]) {
  const Floats4 white = {1, 1, 1, 1};
  Floats4 emission[kLanes];
  find_colours(s, begin, count, lights);
  if (s.emission != nullptr) {
    look_up_lanes(s, *s.emission, s.placed->emission, &PaintedGroup::emission, begin, count,
                  emission);
  }
  for (int k = 0; k < count; ++k) {
    Floats4 of_base, own;
    const float* numbers =
        s.light + kLightNumbers * s.placed->light[static_cast<size_t>(begin + k)];
    load(numbers, of_base);
    load(numbers + 4, own);
    Floats4 light = of_base * lights[k] + own;
    if (s.emission != nullptr) {
      Floats4 emitted;
      load(s.emitted, emitted);
      light += emitted * emission[k];
    }
    lights[k] = light < white ? light : white;
  }
}

SIGHTLINE_MULTIVERSION
void add_all(const PaintedSamples& s, float* sum) {
  Floats4 total;
  load(sum, total);
  for (int begin = 0; begin < s.count; begin += kLanes) {
    Floats4 lights[kLanes];
    const int now = std::min(kLanes, s.count - begin);
    light_eight(s, begin, now, lights);
    for (int k = 0; k < now; ++k) total += lights[k];
  }
  store(total, sum);
}

SIGHTLINE_MULTIVERSION
void paint_all_samples(const PaintedSamples& s, float* light) {
  for (int begin = 0; begin < s.count; begin += kLanes) {
    Floats4 lights[kLanes];
    const int now = std::min(kLanes, s.count - begin);
    light_eight(s, begin, now, lights);
    std::memcpy(light + 4 * begin, lights, sizeof(Floats4) * static_cast<size_t>(now));
  }
}

inline void read_one(const TexelMap& map, const TexelLevel& level, float u, float v,
                     Floats4& rgba) {
  Levels levels;
  put_level(level, 0, levels);
  Floats4 lanes[kLanes];
  const auto texels = [&](int) { return level.texels; };
  read_lanes(map, levels, texels, 0, Floats{} + u, Floats{} + v, 1, lanes);
  rgba = lanes[0];
}

SIGHTLINE_MULTIVERSION
void look_up_two(const TexelMap& map, const TexelLevel& fine, const TexelLevel& coarse, float share,
                 float u, float v, float* rgba) {
  Floats4 colour, smoother;
  read_one(map, fine, u, v, colour);
  if (share > 0) {
    read_one(map, coarse, u, v, smoother);
    colour = (1 - share) * colour + share * smoother;
  }
  if (map.is_weighed) take_alpha_out(colour);
  store(colour, rgba);
}

}  // namespace

void look_up(const TexelMap& map, const TexelLevel& fine, const TexelLevel& coarse, float share,
             float u, float v, float* rgba) {
  look_up_two(map, fine, coarse, share, u, v, rgba);
}

void place_group(PaintedSamples& samples) {
  place_all(samples);
}

void add_painted(const PaintedSamples& samples, float* sum) {
  add_all(samples, sum);
}

void paint_each(const PaintedSamples& samples, float* light) {
  paint_all_samples(samples, light);
}

}  // namespace sightline
