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

}  // namespace

double linear_from_srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

double srgb_from_linear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
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
  return lose(named, "is missing");
}

int TextureShelf::from_bytes(std::string_view bytes, const std::string& name, bool is_srgb) {
  if (const auto known = known_.find({name, is_srgb}); known != known_.end()) return known->second;
  return bytes.empty() ? lose(name, "is missing") : add(name, is_srgb, bytes);
}

int TextureShelf::add(const std::string& name, bool is_srgb, std::string_view bytes) {
  try {
    Texture texture = decode_texture(bytes, pixels_left_);
    texture.name = name;
    texture.is_srgb = is_srgb;
    pixels_left_ -= int64_t{texture.width} * texture.height;
    soup_.textures.push_back(std::move(texture));
  } catch (const InputError& error) {
    return lose(name, error.what());
  }
  const int index = static_cast<int>(soup_.textures.size()) - 1;
  known_[{name, is_srgb}] = index;
  return index;
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
