// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/texture.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sightline {
namespace {

constexpr int kCodes = 256;
constexpr int kFineSteps = 65536;  // of linear light, enough to find the code of any

double decoded(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

double encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

const float* linear_table(bool is_srgb) {
  static const auto kTables = [] {
    std::array<std::array<float, kCodes>, 2> tables{};
    for (int code = 0; code < kCodes; ++code) {
      tables[0][code] = static_cast<float>(code / 255.0);
      tables[1][code] = static_cast<float>(decoded(code / 255.0));
    }
    return tables;
  }();
  return kTables[is_srgb ? 1 : 0].data();
}

uint8_t code_of(float linear, bool is_srgb) {
  static const auto kCodesOfLight = [] {
    std::vector<uint8_t> codes(kFineSteps);
    for (int i = 0; i < kFineSteps; ++i) {
      codes[i] = static_cast<uint8_t>(std::lround(255 * encoded(i / (kFineSteps - 1.0))));
    }
    return codes;
  }();
  const float clamped = std::clamp(linear, 0.0f, 1.0f);
  if (!is_srgb) return static_cast<uint8_t>(std::lround(255 * clamped));
  return kCodesOfLight[static_cast<size_t>(std::lround((kFineSteps - 1) * clamped))];
}

// The largest whole number that is not greater; a call of the library costs more than the rest.
int64_t floor_of(float x) {
  const auto whole = static_cast<int64_t>(x);
  return whole - (static_cast<float>(whole) > x ? 1 : 0);
}

// A coordinate within [0, 1], or just beyond for the blend across a repeated border.
float wrapped(float coordinate, Wrap wrap) {
  switch (wrap) {
    case Wrap::kRepeat:
      return coordinate - static_cast<float>(floor_of(coordinate));
    case Wrap::kMirror: {
      const float half = coordinate / 2;
      const float folded = 2 * (half - static_cast<float>(floor_of(half)));
      return folded <= 1 ? folded : 2 - folded;
    }
    case Wrap::kClamp:
      break;
  }
  return std::clamp(coordinate, 0.0f, 1.0f);
}

// The texel of an index that is at most one beyond the border.
int texel_at(int index, int count, Wrap wrap) {
  if (index < 0) return wrap == Wrap::kRepeat ? count - 1 : 0;
  if (index >= count) return wrap == Wrap::kRepeat ? 0 : count - 1;
  return index;
}

// How much of [begin, end] texel i covers.
float share(float begin, float end, int i) {
  return std::min(end, static_cast<float>(i + 1)) - std::max(begin, static_cast<float>(i));
}

}  // namespace

TexturePyramid::TexturePyramid(std::shared_ptr<const Texture> texture, bool weighs_alpha)
    : texture_(std::move(texture)),
      weighs_alpha_(weighs_alpha),
      linear_(linear_table(texture_->is_srgb)),
      alpha_(linear_table(false)) {
  levels_.push_back({texture_->width, texture_->height, {}, texture_->rgba.data()});
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    levels_.push_back(halved(levels_.back()));
    levels_.back().rgba = levels_.back().own.data();
  }
}

void TexturePyramid::add(const uint8_t* texel, float weight, Eigen::Array4f& sum) const {
  const float alpha = alpha_[texel[3]];
  const Eigen::Array4f light(linear_[texel[0]], linear_[texel[1]], linear_[texel[2]], alpha);
  if (!weighs_alpha_) {
    sum += weight * light;
    return;
  }
  sum += weight * alpha * Eigen::Array4f(light[0], light[1], light[2], 1);
}

Eigen::Array4f TexturePyramid::unweighed(Eigen::Array4f sum) const {
  if (weighs_alpha_ && sum[3] > 0) sum.head<3>() /= sum[3];
  return sum;
}

TexturePyramid::Level TexturePyramid::halved(const Level& level) const {
  Level out{std::max(1, level.width / 2), std::max(1, level.height / 2), {}, nullptr};
  out.own.resize(size_t{4} * out.width * out.height);
  const float across = static_cast<float>(level.width) / static_cast<float>(out.width);
  const float down = static_cast<float>(level.height) / static_cast<float>(out.height);
  for (int y = 0; y < out.height; ++y) {
    const float top = down * static_cast<float>(y);
    for (int x = 0; x < out.width; ++x) {
      const float left = across * static_cast<float>(x);
      Eigen::Array4f sum = Eigen::Array4f::Zero();
      for (int v = static_cast<int>(top); v < level.height && v < top + down; ++v) {
        const float height = share(top, top + down, v);
        for (int u = static_cast<int>(left); u < level.width && u < left + across; ++u) {
          const float weight = height * share(left, left + across, u) / (across * down);
          add(level.rgba + 4 * (static_cast<size_t>(v) * level.width + u), weight, sum);
        }
      }
      sum = unweighed(sum);
      uint8_t* to = out.own.data() + 4 * (static_cast<size_t>(y) * out.width + x);
      for (int c = 0; c < 3; ++c) to[c] = code_of(sum[c], texture_->is_srgb);
      to[3] = code_of(sum[3], false);
    }
  }
  return out;
}

Eigen::Array4f TexturePyramid::nearest(const Level& level, const TextureRef& ref, float u,
                                       float v) const {
  const int x = static_cast<int>(wrapped(u, ref.wrap_u) * static_cast<float>(level.width));
  const int y = static_cast<int>(wrapped(v, ref.wrap_v) * static_cast<float>(level.height));
  const int column = std::min(x, level.width - 1);
  const int row = std::min(y, level.height - 1);
  Eigen::Array4f sum = Eigen::Array4f::Zero();
  add(level.rgba + 4 * (static_cast<size_t>(row) * level.width + column), 1, sum);
  return unweighed(sum);
}

Eigen::Array4f TexturePyramid::bilinear(const Level& level, const TextureRef& ref, float u,
                                        float v) const {
  const float x = wrapped(u, ref.wrap_u) * static_cast<float>(level.width) - 0.5f;
  const float y = wrapped(v, ref.wrap_v) * static_cast<float>(level.height) - 0.5f;
  const int left = static_cast<int>(floor_of(x));
  const int top = static_cast<int>(floor_of(y));
  const float right_share = x - static_cast<float>(left);
  const float bottom_share = y - static_cast<float>(top);
  const int columns[2] = {texel_at(left, level.width, ref.wrap_u),
                          texel_at(left + 1, level.width, ref.wrap_u)};
  const int rows[2] = {texel_at(top, level.height, ref.wrap_v),
                       texel_at(top + 1, level.height, ref.wrap_v)};
  Eigen::Array4f sum = Eigen::Array4f::Zero();
  for (int i = 0; i < 2; ++i) {
    const uint8_t* row = level.rgba + 4 * static_cast<size_t>(rows[i]) * level.width;
    const float height = i == 0 ? 1 - bottom_share : bottom_share;
    add(row + 4 * static_cast<size_t>(columns[0]), height * (1 - right_share), sum);
    add(row + 4 * static_cast<size_t>(columns[1]), height * right_share, sum);
  }
  return unweighed(sum);
}

Eigen::Array4f TexturePyramid::at(const TextureRef& ref, float u, float v, float level) const {
  if (!(level > 0)) {
    return ref.is_nearest ? nearest(levels_.front(), ref, u, v)
                          : bilinear(levels_.front(), ref, u, v);
  }
  const auto last = static_cast<float>(levels_.size() - 1);
  const float within = std::min(level, last);
  const auto fine = static_cast<size_t>(within);
  const float towards_coarse = within - static_cast<float>(fine);
  const Eigen::Array4f near = bilinear(levels_[fine], ref, u, v);
  if (!(towards_coarse > 0)) return near;
  return near + towards_coarse * (bilinear(levels_[fine + 1], ref, u, v) - near);
}

const TexturePyramid& TextureCache::pyramid(const std::shared_ptr<const Texture>& texture,
                                            bool weighs_alpha) {
  std::unique_ptr<TexturePyramid>& pyramid = pyramids_[{texture.get(), weighs_alpha}];
  if (!pyramid) pyramid = std::make_unique<TexturePyramid>(texture, weighs_alpha);
  return *pyramid;
}

}  // namespace sightline
