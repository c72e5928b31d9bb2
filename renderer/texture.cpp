// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/texture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/mesh/textures.h"

namespace sightline {
namespace {

constexpr int kCodes = 256;
constexpr double kWhite = 65535;

// Linear light of each of a texture's numbers.
std::array<uint16_t, kCodes> linear_codes(bool is_srgb) {
  std::array<uint16_t, kCodes> codes{};
  for (int code = 0; code < kCodes; ++code) {
    const double value = code / (kCodes - 1.0);
    codes[code] =
        static_cast<uint16_t>(std::lround(kWhite * (is_srgb ? linear_from_srgb(value) : value)));
  }
  return codes;
}

Border border_of(Wrap wrap) {
  switch (wrap) {
    case Wrap::kMirror:
      return Border::kMirror;
    case Wrap::kClamp:
      return Border::kClamp;
    case Wrap::kRepeat:
      break;
  }
  return Border::kRepeat;
}

// How much of [begin, end] texel i covers.
float share(float begin, float end, int i) {
  return std::min(end, static_cast<float>(i + 1)) - std::max(begin, static_cast<float>(i));
}

}  // namespace

TexturePyramid::TexturePyramid(const Texture& texture, bool weighs_alpha)
    : weighs_alpha_(weighs_alpha) {
  levels_.push_back(first_level(texture, weighs_alpha));
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    levels_.push_back(halved(levels_.back()));
  }
}

TexturePyramid::Level TexturePyramid::first_level(const Texture& texture, bool weighs_alpha) {
  static const auto kLinear = std::array{linear_codes(false), linear_codes(true)};
  const auto& colours = kLinear[texture.is_srgb ? 1 : 0];
  const auto& alphas = kLinear[0];
  Level level{texture.width, texture.height, {}};
  level.texels.resize(TexelLevel::numbers(level.width, level.height));
  const uint8_t* from = texture.rgba.data();
  for (int y = 0; y < level.height; ++y) {
    for (int x = 0; x < level.width; ++x, from += 4) {
      uint16_t* to = level.texel(x, y);
      const double share = weighs_alpha ? alphas[from[3]] / kWhite : 1;
      for (int c = 0; c < 3; ++c) {
        to[c] = static_cast<uint16_t>(colours[from[c]] * share + 0.5);
      }
      to[3] = alphas[from[3]];
    }
  }
  return level;
}

TexturePyramid::Level TexturePyramid::halved(Level& level) {
  Level out{std::max(1, level.width / 2), std::max(1, level.height / 2), {}};
  out.texels.resize(TexelLevel::numbers(out.width, out.height));
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
          const uint16_t* texel = level.texel(u, v);
          sum += weight * Eigen::Array4f(texel[0], texel[1], texel[2], texel[3]);
        }
      }
      uint16_t* to = out.texel(x, y);
      for (int c = 0; c < 4; ++c) to[c] = static_cast<uint16_t>(sum[c] + 0.5f);
    }
  }
  return out;
}

TexelMap TexturePyramid::map(const TextureRef& ref) const {
  TexelMap map;
  map.is_weighed = weighs_alpha_;
  map.border_u = border_of(ref.wrap_u);
  map.border_v = border_of(ref.wrap_v);
  for (size_t i = 0; i < 6; ++i) map.from_uv[i] = static_cast<float>(ref.texture_from_uv[i]);
  return map;
}

TexelLevel TexturePyramid::level(const TextureRef& ref, int level) const {
  const int smallest = static_cast<int>(levels_.size()) - 1;
  TexelLevel read = levels_[static_cast<size_t>(std::clamp(level, 0, smallest))].view();
  read.is_nearest = level <= 0 && ref.is_nearest;
  return read;
}

Eigen::Array4f TexturePyramid::at(const TextureRef& ref, float u, float v, float level) const {
  const bool is_minified = level > 0;  // not where it is not a number
  const float within = is_minified ? std::min(level, static_cast<float>(levels_.size() - 1)) : 0;
  const int fine = static_cast<int>(within);
  TexelLevel fine_level = this->level(ref, fine);
  fine_level.is_nearest &= !is_minified;
  Eigen::Array4f rgba;
  look_up(map(ref), fine_level, this->level(ref, fine + 1), within - static_cast<float>(fine), u, v,
          rgba.data());
  return rgba;
}

const TexturePyramid& TextureCache::pyramid(const std::shared_ptr<const Texture>& texture,
                                            bool weighs_alpha) {
  auto found = pyramids_.find(texture);
  if (found == pyramids_.end()) {
    // Of a folder's pictures each scene has another.
    std::erase_if(pyramids_, [](const auto& entry) { return entry.first.expired(); });
    found = pyramids_.try_emplace(texture).first;
  }
  std::unique_ptr<TexturePyramid>& pyramid = found->second[weighs_alpha ? 1 : 0];
  if (!pyramid) pyramid = std::make_unique<TexturePyramid>(*texture, weighs_alpha);
  return *pyramid;
}

}  // namespace sightline
