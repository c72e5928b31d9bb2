// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/pictures.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace sightline {
namespace {

std::string encoded(const char* extension, const cv::Mat& picture) {
  std::vector<uchar> bytes;
  cv::imencode(extension, picture, bytes);  // no parameters: any is slower
  return {bytes.begin(), bytes.end()};
}

// What is torn off a JPEG is filled in with grey when it is read, and nobody told. Its end marker
// is looked for in the second half: a thumbnail at the beginning may have one of its own.
bool is_torn_jpeg(const std::filesystem::path& file) {
  constexpr std::string_view kBegin = "\xff\xd8";
  constexpr std::string_view kEnd = "\xff\xd9";
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(kBegin.size(), '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!stream || bytes != kBegin) return false;
  bytes.append(std::istreambuf_iterator<char>(stream), {});
  return bytes.find(kEnd, bytes.size() / 2) == std::string::npos;
}

uint32_t big_endian(std::string_view bytes, size_t at, size_t count) {
  uint32_t value = 0;
  for (size_t i = 0; i < count; ++i) value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  return value;
}

uint32_t little_endian(std::string_view bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = 4; i-- > 0;) value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  return value;
}

cv::Size size_of(uint32_t width, uint32_t height) {
  return {static_cast<int>(std::min<uint32_t>(width, INT32_MAX)),
          static_cast<int>(std::min<uint32_t>(height, INT32_MAX))};
}

// Of a JPEG, whose frame header stands behind segments of which each states its length.
std::optional<cv::Size> jpeg_size(std::ifstream& stream) {
  constexpr int kMostSegments = 1000;
  stream.clear();
  stream.seekg(2);
  for (int i = 0; i < kMostSegments; ++i) {
    std::string head(4, '\0');
    if (!stream.read(head.data(), 4) || head[0] != '\xff') return std::nullopt;
    const uint32_t marker = big_endian(head, 1, 1);
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    const uint32_t length = big_endian(head, 2, 2);
    if (!is_frame) {
      stream.seekg(static_cast<std::streamoff>(length) - 2, std::ios::cur);
      continue;
    }
    std::string frame(5, '\0');
    if (!stream.read(frame.data(), 5)) return std::nullopt;
    return size_of(big_endian(frame, 3, 2), big_endian(frame, 1, 2));
  }
  return std::nullopt;
}

// What the header of a format that states it simply says; none of others.
std::optional<cv::Size> stated_size(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string head(26, '\0');
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  if (stream.gcount() < static_cast<std::streamsize>(head.size())) return std::nullopt;
  if (head.starts_with("\x89PNG\r\n")) {
    return size_of(big_endian(head, 16, 4), big_endian(head, 20, 4));
  }
  if (head.starts_with("\xff\xd8")) return jpeg_size(stream);
  if (head.starts_with("BM")) {  // a height below zero says that its top row comes first
    const auto height = static_cast<int32_t>(little_endian(head, 22));
    return size_of(little_endian(head, 18), static_cast<uint32_t>(std::abs(int64_t{height})));
  }
  return std::nullopt;
}

}  // namespace

std::string six_digits(int64_t number) {
  return fmt::format("{:06}", number);
}

std::string png_bytes(const cv::Mat& picture) {
  return encoded(".png", picture);
}

std::string tiff_bytes(const cv::Mat& picture) {
  return encoded(".tiff", picture);
}

std::optional<cv::Size> picture_size(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return std::nullopt;
  if (const auto stated = stated_size(file)) return stated;
  const cv::Mat picture = read_picture(file);
  if (picture.empty()) return std::nullopt;
  return picture.size();
}

cv::Mat read_picture(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return {};
  const auto stated = stated_size(file);
  if (stated && int64_t{stated->width} * stated->height > kMostPicturePixels) return {};
  if (is_torn_jpeg(file)) return {};
  try {
    return cv::imread(file.string(), cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    return {};
  }
}

cv::Mat read_grey_picture(const std::filesystem::path& file) {
  const cv::Mat picture = read_picture(file);
  if (picture.depth() != CV_8U && picture.depth() != CV_16U) return {};
  cv::Mat grey;
  switch (picture.channels()) {
    case 1:
      return picture;
    case 3:
      cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
      return grey;
    case 4:
      cv::cvtColor(picture, grey, cv::COLOR_BGRA2GRAY);
      return grey;
    default:
      return {};
  }
}

}  // namespace sightline
