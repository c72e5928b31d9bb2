// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/pictures.h"

#include <fstream>
#include <iterator>
#include <string_view>
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

cv::Mat read_picture(const std::filesystem::path& file) {
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
