// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/grey_image.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace sightline {
namespace {

constexpr float kClippedFromGrey = 254.5F;

float linear_from_srgb(float grey) {
  const float x = grey / 255;
  return 255 * (x <= 0.04045F ? x / 12.92F : std::pow((x + 0.055F) / 1.055F, 2.4F));
}

}  // namespace

GreyImage grey_image(const cv::Mat& image, double white, bool is_srgb, const Camera& camera) {
  GreyImage out;
  out.camera = camera;
  image.convertTo(out.grey, CV_32F, 255 / white);
  out.is_clipped = out.grey >= kClippedFromGrey;
  if (!is_srgb) return out;
  for (int y = 0; y < out.grey.rows; ++y) {
    float* const row = out.grey.ptr<float>(y);
    std::transform(row, row + out.grey.cols, row, linear_from_srgb);
  }
  return out;
}

GreyImage shrunk(const GreyImage& image, int factor) {
  GreyImage out;
  out.camera = image.camera;
  Camera& camera = out.camera;
  camera.width_px = image.grey.cols / factor;
  camera.height_px = image.grey.rows / factor;
  camera.fx_px /= factor;
  camera.fy_px /= factor;
  camera.skew_px /= factor;
  // The centre of the first large pixel is that of the block that it covers.
  camera.cx_px = (camera.cx_px - (factor - 1) / 2.0) / factor;
  camera.cy_px = (camera.cy_px - (factor - 1) / 2.0) / factor;
  const cv::Size size(camera.width_px, camera.height_px);
  const cv::Rect whole(0, 0, size.width * factor, size.height * factor);
  cv::resize(image.grey(whole), out.grey, size, 0, 0, cv::INTER_AREA);
  cv::Mat clipped;
  cv::resize(image.is_clipped(whole), clipped, size, 0, 0, cv::INTER_AREA);
  out.is_clipped = clipped > 0;
  return out;
}

cv::Mat blurred(const cv::Mat& image, double sigma_px) {
  constexpr double kNegligible = 0.02;
  if (sigma_px < kNegligible) return image.clone();
  const int size = 2 * static_cast<int>(std::ceil(4 * sigma_px)) + 1;
  cv::Mat out;
  cv::GaussianBlur(image, out, {size, size}, sigma_px, sigma_px, cv::BORDER_REPLICATE);
  return out;
}

double estimated_noise_sd(const cv::Mat& grey) {
  constexpr double kLeast = 0.3;
  constexpr double kNormalMedian = 0.6745;  // of the absolute value, unit standard deviation
  constexpr double kFilterNorm = 6;         // the root of the sum of its squares
  const cv::Mat across = (cv::Mat_<float>(1, 3) << 1, -2, 1);
  cv::Mat rest;
  cv::sepFilter2D(grey, rest, CV_32F, across, across);
  std::vector<float> sizes;
  sizes.reserve(rest.total());
  for (int y = 1; y + 1 < rest.rows; ++y) {
    const float* const row = rest.ptr<float>(y);
    for (int x = 1; x + 1 < rest.cols; ++x) sizes.push_back(std::abs(row[x]));
  }
  if (sizes.empty()) return kLeast;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return std::max(kLeast, *middle / kNormalMedian / kFilterNorm);
}

}  // namespace sightline
