// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/textures.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <sys/resource.h>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

struct PictureSize {
  int64_t width = 0;
  int64_t height = 0;
};

// A number of `count` bytes of a picture's header; 0 where the header ends before.
uint32_t big_endian(std::string_view bytes, size_t at, size_t count) {
  if (at + count > bytes.size()) return 0;
  uint32_t value = 0;
  for (size_t i = 0; i < count; ++i) value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  return value;
}

uint32_t little_endian(std::string_view bytes, size_t at, size_t count) {
  if (at + count > bytes.size()) return 0;
  uint32_t value = 0;
  for (size_t i = count; i-- > 0;) value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  return value;
}

// A JPEG's size stands in the frame's header, the first of the markers C0 to CF that is no table.
PictureSize jpeg_size(std::string_view bytes) {
  size_t at = 2;
  while (at + 4 <= bytes.size() && static_cast<uint8_t>(bytes[at]) == 0xff) {
    const auto marker = static_cast<uint8_t>(bytes[at + 1]);
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (is_frame) return {big_endian(bytes, at + 7, 2), big_endian(bytes, at + 5, 2)};
    const bool is_fill = marker == 0xff;
    at += is_fill ? 1 : 2 + big_endian(bytes, at + 2, 2);
  }
  return {};
}

PictureSize webp_size(std::string_view bytes) {
  const std::string_view kind = bytes.substr(12, 4);
  if (kind == "VP8X") {
    return {1 + int64_t{little_endian(bytes, 24, 3)}, 1 + int64_t{little_endian(bytes, 27, 3)}};
  }
  if (kind == "VP8L") {
    const uint32_t bits = little_endian(bytes, 21, 4);
    return {1 + int64_t{bits & 0x3fff}, 1 + int64_t{bits >> 14 & 0x3fff}};
  }
  return {little_endian(bytes, 26, 2) & 0x3fff, little_endian(bytes, 28, 2) & 0x3fff};
}

// The size that a picture's header states; none of a format that is not known here.
std::optional<PictureSize> stated_size(std::string_view bytes) {
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) {
    return PictureSize{big_endian(bytes, 16, 4), big_endian(bytes, 20, 4)};
  }
  if (bytes.starts_with("\xff\xd8")) return jpeg_size(bytes);
  if (bytes.starts_with("BM")) {
    const auto height = static_cast<int32_t>(little_endian(bytes, 22, 4));  // below 0: top first
    return PictureSize{little_endian(bytes, 18, 4), std::abs(int64_t{height})};
  }
  if (bytes.starts_with("RIFF") && bytes.size() > 16 && bytes.substr(8, 4) == "WEBP") {
    return webp_size(bytes);
  }
  return std::nullopt;
}

// What is torn off a picture may be filled in by its decoder, and nobody told.
bool has_end(std::string_view bytes) {
  if (bytes.starts_with("\xff\xd8")) return bytes.rfind("\xff\xd9") != std::string_view::npos;
  if (bytes.starts_with("\x89PNG")) return bytes.rfind("IEND") != std::string_view::npos;
  return true;
}

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

std::optional<std::string> read_bytes(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(stream)), {});
  if (!stream) return std::nullopt;
  return bytes;
}

}  // namespace

double linear_from_srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

Texture decode_texture(std::string_view bytes, int64_t pixels_left) {
  const std::optional<PictureSize> size = stated_size(bytes);
  if (!size) throw InputError("is of a format unknown here (known: PNG, JPEG, BMP, WebP)");
  if (size->width > kMaxTextureSide || size->height > kMaxTextureSide) {
    throw InputError(fmt::format("has {} x {} px, must have at most {} px a side", size->width,
                                 size->height, kMaxTextureSide));
  }
  const int64_t pixels = size->width * size->height;
  if (pixels > pixels_left) {
    throw InputError(fmt::format("is one too many: a mesh's textures have at most {} px in all",
                                 kMaxTexturePixels));
  }
  cv::Mat picture;
  if (pixels > 0 && has_end(bytes)) {
    make_room_for(pixels);
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U,
                          const_cast<char*>(bytes.data()));
    try {
      picture = cv::imdecode(encoded, cv::IMREAD_UNCHANGED);
    } catch (const cv::Exception&) {
    }
  }
  const bool is_whole = picture.cols == size->width && picture.rows == size->height &&
                        (picture.depth() == CV_8U || picture.depth() == CV_16U);
  if (pixels == 0 || !is_whole) throw InputError("is torn or broken");
  Texture texture{.name = "", .width = picture.cols, .height = picture.rows, .rgba = {}};
  texture.rgba.reserve(static_cast<size_t>(4 * pixels));
  if (picture.depth() == CV_8U) to_rgba<uint8_t>(picture, texture.rgba);
  if (picture.depth() == CV_16U) to_rgba<uint16_t>(picture, texture.rgba);
  return texture;
}

TextureShelf::TextureShelf(MeshSoup& soup, const std::filesystem::path& mesh_file)
    : soup_(soup), folder_(std::filesystem::absolute(mesh_file).parent_path()) {}

int TextureShelf::from_file(const std::string& named, bool is_srgb) {
  if (const auto known = known_.find({named, is_srgb}); known != known_.end()) {
    return known->second;
  }
  std::string path = named;
  std::replace(path.begin(), path.end(), '\\', '/');
  const std::filesystem::path given = path;
  // As it is named, else beside the mesh: a path of the machine where the mesh was made.
  for (const std::filesystem::path& file : {folder_ / given, folder_ / given.filename()}) {
    std::error_code none;
    if (!std::filesystem::is_regular_file(file, none) || !is_inside(folder_, file)) continue;
    if (const auto bytes = read_bytes(file)) return add(named, is_srgb, *bytes);
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
