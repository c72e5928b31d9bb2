// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/sensor.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace sightline {
namespace {

cv::Mat blurred(const cv::Mat& linear, double sigma_px) {
  if (sigma_px <= 0) return linear;
  // 4 sigma leave 6e-5 of the light out.
  const int size = 2 * static_cast<int>(std::ceil(4 * sigma_px)) + 1;
  cv::Mat out;
  cv::GaussianBlur(linear, out, {size, size}, sigma_px, sigma_px, cv::BORDER_REPLICATE);
  return out;
}

template <typename Pixel>
cv::Mat quantised(const cv::Mat& light, const Sensor& sensor, int type, RandomStream& noise) {
  const double white = std::exp2(sensor.bits) - 1;
  const double read_sd = sensor.read_noise_grey / 255;
  const bool has_photon_noise = sensor.full_well_electrons > 0;
  const bool has_noise = read_sd > 0 || has_photon_noise;
  cv::Mat out(light.size(), type);
  for (int v = 0; v < light.rows; ++v) {
    const float* from = light.ptr<float>(v);
    Pixel* to = out.ptr<Pixel>(v);
    for (int u = 0; u < light.cols; ++u) {
      double value = from[u];
      if (has_noise) {
        const double photon_variance =
            has_photon_noise ? std::max(0.0, value) / sensor.full_well_electrons : 0;
        value += std::sqrt(read_sd * read_sd + photon_variance) * noise.normal();
      }
      to[u] = static_cast<Pixel>(std::clamp(std::round(value * white), 0.0, white));
    }
  }
  return out;
}

}  // namespace

cv::Mat expose(const cv::Mat& linear, const Sensor& sensor, RandomStream noise) {
  const cv::Mat light = blurred(linear, sensor.psf_sigma_px);
  return sensor.bits <= 8 ? quantised<uint8_t>(light, sensor, CV_8U, noise)
                          : quantised<uint16_t>(light, sensor, CV_16U, noise);
}

}  // namespace sightline
