// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/datasets/pictures.h"

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "scenes/picture/picture_file.h"

namespace sightline {

std::string six_digits(int64_t number) {
  return fmt::format("{:06}", number);
}

cv::Mat read_picture(const std::filesystem::path& file) {
  return read_picture_file(file).pixels;
}

cv::Mat read_grey_picture(const std::filesystem::path& file) {
  return grey_of(read_picture(file));
}

cv::Mat grey_of(const cv::Mat& picture) {
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
