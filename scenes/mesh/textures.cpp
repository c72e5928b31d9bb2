// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/textures.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <sys/resource.h>

#include "scenes/files/input_error.h"
#include "scenes/picture/picture_file.h"

namespace sightline {
namespace {

void raise(int resource, uint64_t by) {
  rlimit now{};
  if (getrlimit(resource, &now) != 0 || now.rlim_cur == RLIM_INFINITY) return;
  now.rlim_cur = std::min<rlim_t>(now.rlim_cur + by, now.rlim_max);
  setrlimit(resource, &now);
}

// The reader's limits are measured by the mesh's file; a texture of a size that is allowed may take
// what its pixels need.
void make_room_for(int64_t pixels) {
  constexpr uint64_t kBytesAPixel = 24;           // decoded at 16 bits, turned, sent to the parent
  constexpr int64_t kPixelsASecond = 10'000'000;  // decoders of pictures do ten times as many
  raise(RLIMIT_AS, kBytesAPixel * static_cast<uint64_t>(pixels));
  raise(RLIMIT_CPU, static_cast<uint64_t>(1 + pixels / kPixelsASecond));
}

template <typename Channel>
void to_rgba(const cv::Mat& picture, std::vector<uint8_t>& rgba) {
  const int channels = picture.channels();
  const bool is_grey = channels < 3;
  const bool has_alpha = channels == 2 || channels == 4;
  const auto eight_bits = [](Channel value) {
    return static_cast<uint8_t>(sizeof(Channel) == 1 ? value : (value + 128) / 257);
  };
  for (int v = 0; v < picture.rows; ++v) {
    const Channel* from = picture.ptr<Channel>(v);
    for (int u = 0; u < picture.cols; ++u, from += channels) {
      rgba.push_back(eight_bits(from[is_grey ? 0 : 2]));  // OpenCV has blue first
      rgba.push_back(eight_bits(from[is_grey ? 0 : 1]));
      rgba.push_back(eight_bits(from[0]));
      rgba.push_back(has_alpha ? eight_bits(from[channels - 1]) : 255);
    }
  }
}

// The opacity that a picture says by its alpha or, where that is full, by its brightness; row by
// row. By hand, since OpenCV's threads are not there in a reader's process.
std::vector<uint8_t> alphas_of(const Texture& picture, bool by_brightness) {
  std::vector<uint8_t> alphas(picture.rgba.size() / 4);
  for (size_t i = 0; i < alphas.size(); ++i) alphas[i] = picture.rgba[4 * i + 3];
  if (!by_brightness || std::any_of(alphas.begin(), alphas.end(), [](int a) { return a != 255; })) {
    return alphas;
  }
  // Grey of the stored numbers, as pictures in grey are made (BT.601).
  for (size_t i = 0; i < alphas.size(); ++i) {
    const uint8_t* texel = picture.rgba.data() + 4 * i;
    alphas[i] =
        static_cast<uint8_t>((299 * texel[0] + 587 * texel[1] + 114 * texel[2] + 500) / 1000);
  }
  return alphas;
}

// What a surface of these opacities needs.
AlphaMode mode_of(const std::vector<uint8_t>& alphas) {
  const auto is = [&](auto... values) {
    return std::all_of(alphas.begin(), alphas.end(), [=](int a) { return ((a == values) || ...); });
  };
  if (is(255)) return AlphaMode::kOpaque;
  return is(0, 255) ? AlphaMode::kMask : AlphaMode::kBlend;
}

Texture white(cv::Size size) {
  Texture texture{.name = "", .width = size.width, .height = size.height, .rgba = {}};
  texture.rgba.assign(4 * static_cast<size_t>(size.width) * static_cast<size_t>(size.height), 255);
  return texture;
}

// Lays the opacity of a picture of another size on a texture: that of the nearest of its texels.
void put_alphas(const std::vector<uint8_t>& alphas, cv::Size size, Texture& on) {
  for (int v = 0; v < on.height; ++v) {
    const int64_t row = (2 * int64_t{v} + 1) * size.height / (2 * int64_t{on.height});
    for (int u = 0; u < on.width; ++u) {
      const int64_t column = (2 * int64_t{u} + 1) * size.width / (2 * int64_t{on.width});
      on.rgba[4 * (size_t(v) * on.width + u) + 3] = alphas[row * size.width + column];
    }
  }
}

}  // namespace

double linear_from_srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

double srgb_from_linear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double within_unit(double value) {
  return value > 0 ? std::min(value, 1.0) : 0.0;
}

Texture decode_texture(std::string_view bytes, int64_t pixels_left) {
  const std::optional<cv::Size> size = picture_size(bytes);
  if (!size) throw InputError("is of a format unknown here (known: PNG, JPEG, BMP, WebP, TIFF)");
  if (size->width > kMaxTextureSide || size->height > kMaxTextureSide) {
    throw InputError(fmt::format("has {} x {} px, must have at most {} px a side", size->width,
                                 size->height, kMaxTextureSide));
  }
  const int64_t pixels = int64_t{size->width} * size->height;
  if (pixels > pixels_left) {
    throw InputError(fmt::format("is one too many: a mesh's textures have at most {} px in all",
                                 kMaxTexturePixels));
  }
  make_room_for(pixels);
  const auto [picture, problem] = decode_picture(bytes);
  if (!problem.empty()) throw InputError(problem);
  if (picture.depth() == CV_32F) throw InputError("holds numbers, not colours");
  Texture texture{.name = "", .width = picture.cols, .height = picture.rows, .rgba = {}};
  texture.rgba.reserve(static_cast<size_t>(4 * pixels));
  if (picture.depth() == CV_8U) to_rgba<uint8_t>(picture, texture.rgba);
  if (picture.depth() == CV_16U) to_rgba<uint16_t>(picture, texture.rgba);
  return texture;
}

TextureShelf::TextureShelf(MeshSoup& soup, const std::filesystem::path& mesh_file)
    : soup_(soup), folder_(mesh_file) {}

int TextureShelf::from_file(const std::string& named, bool is_srgb) {
  if (const auto known = known_.find({named, is_srgb}); known != known_.end()) {
    return known->second;
  }
  std::string path = named;
  std::replace(path.begin(), path.end(), '\\', '/');
  const std::filesystem::path given = path;
  // As it is named, else beside the mesh: a path of the machine where the mesh was made.
  for (const std::filesystem::path& place : {given, given.filename()}) {
    const auto file = folder_.find(place);
    if (!file) continue;
    if (const auto bytes = whole_file(*file)) return add(named, is_srgb, *bytes);
  }
  return miss(named);
}

int TextureShelf::from_bytes(std::string_view bytes, const std::string& name, bool is_srgb) {
  if (const auto known = known_.find({name, is_srgb}); known != known_.end()) return known->second;
  return bytes.empty() ? miss(name) : add(name, is_srgb, bytes);
}

std::pair<int, AlphaMode> TextureShelf::with_alpha(int colour, int alpha) {
  const Texture& from = soup_.textures[alpha];
  const cv::Size size(from.width, from.height);
  const std::string of_alpha = from.name;
  const bool is_same = colour >= 0 && soup_.textures[colour].name == of_alpha;
  const std::vector<uint8_t> alphas = alphas_of(from, !is_same);
  if (alpha != colour) let_go(alpha);  // nothing but its opacity was asked for
  const AlphaMode mode = mode_of(alphas);
  if (is_same || mode == AlphaMode::kOpaque) return {colour, mode};
  const Texture* const under = colour >= 0 ? &soup_.textures[colour] : nullptr;
  const std::string name = fmt::format("{} within {}", under ? under->name : "white", of_alpha);
  const int64_t pixels =
      under ? int64_t{under->width} * under->height : int64_t{size.width} * size.height;
  if (pixels > pixels_left_) {
    lose(name, "is one too many");
    return {colour, AlphaMode::kOpaque};
  }
  make_room_for(pixels);
  Texture cut = under ? *under : white(size);
  put_alphas(alphas, size, cut);
  cut.name = name;
  cut.is_srgb = true;
  return {keep(std::move(cut)), mode};
}

int TextureShelf::add(const std::string& name, bool is_srgb, std::string_view bytes) {
  try {
    Texture texture = decode_texture(bytes, pixels_left_);
    texture.name = name;
    texture.is_srgb = is_srgb;
    return keep(std::move(texture));
  } catch (const InputError& error) {
    return lose(name, error.what());
  }
}

int TextureShelf::keep(Texture texture) {
  const int index = static_cast<int>(soup_.textures.size());
  pixels_left_ -= int64_t{texture.width} * texture.height;
  known_[{texture.name, texture.is_srgb}] = index;
  soup_.textures.push_back(std::move(texture));
  return index;
}

// The last one alone can go, else others would change their index.
void TextureShelf::let_go(int index) {
  if (index + 1 != static_cast<int>(soup_.textures.size())) return;
  const Texture& last = soup_.textures.back();
  pixels_left_ += int64_t{last.width} * last.height;
  known_.erase({last.name, last.is_srgb});
  soup_.textures.pop_back();
}

int TextureShelf::miss(const std::string& named) {
  std::string path = named;
  std::replace(path.begin(), path.end(), '\\', '/');
  return lose(named, folder_.is_outside(path) ? "lies outside the mesh's folder and is not read"
                                              : "is missing");
}

int TextureShelf::lose(const std::string& name, const std::string& reason) {
  constexpr size_t kMaxLost = 1000;
  const std::string sentence = fmt::format("texture {} {}", name, reason);
  auto& lost = soup_.lost_textures;
  const bool is_told = std::find(lost.begin(), lost.end(), sentence) != lost.end();
  if (!is_told && lost.size() < kMaxLost) lost.push_back(sentence);
  return -1;
}

}  // namespace sightline
