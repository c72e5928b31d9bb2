// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstdlib>
#include <memory>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "scenes/picture/codecs.h"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_BMP
#define STBI_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wshadow"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

namespace sightline {
namespace {

uint32_t number_at(std::string_view bytes, size_t at, size_t count) {
  if (at + count > bytes.size()) return 0;
  uint32_t value = 0;
  for (size_t i = count; i-- > 0;) value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  return value;
}

// The reader itself takes what is missing for zeros.
bool holds_its_rows(std::string_view bytes, cv::Size size) {
  const uint64_t bits_a_pixel = number_at(bytes, 28, 2);
  const uint64_t row_bytes = (bits_a_pixel * static_cast<uint64_t>(size.width) + 31) / 32 * 4;
  return number_at(bytes, 10, 4) + row_bytes * static_cast<uint64_t>(size.height) <= bytes.size();
}

}  // namespace

std::optional<cv::Size> bmp_size(std::string_view bytes) {
  constexpr size_t kHeadBytes = 30;
  if (bytes.size() < kHeadBytes) return std::nullopt;
  const int64_t height = static_cast<int32_t>(number_at(bytes, 22, 4));  // below 0: top row first
  const uint32_t width = number_at(bytes, 18, 4);
  if (width > INT32_MAX || std::abs(height) > INT32_MAX) return std::nullopt;
  return cv::Size(static_cast<int>(width), static_cast<int>(std::abs(height)));
}

PictureReading decode_bmp(std::string_view bytes) {
  const std::optional<cv::Size> size = bmp_size(bytes);
  if (!size) return {{}, kTornPicture};
  constexpr int kMostBytesAPixel = 4;
  if (std::string problem = size_problem(size->width, size->height, kMostBytesAPixel);
      !problem.empty()) {
    return {{}, std::move(problem)};
  }
  if (!holds_its_rows(bytes, *size)) return {{}, kTornPicture};
  int width = 0, height = 0, channels = 0;
  constexpr int kColours = 3;
  const std::unique_ptr<stbi_uc, decltype(&std::free)> pixels(
      stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()),
                            static_cast<int>(bytes.size()), &width, &height, &channels, kColours),
      &std::free);
  if (pixels == nullptr || cv::Size(width, height) != *size) return {{}, kTornPicture};
  cv::Mat picture;
  cv::cvtColor(cv::Mat(height, width, CV_8UC3, pixels.get()), picture, cv::COLOR_RGB2BGR);
  return {picture, {}};
}

}  // namespace sightline
