// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/sensor.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

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

// Adds read and photon noise to a row of light. A loop that compilers turn into vector code.
void add_noise(float* light, const float* normals, int count, const Sensor& sensor) {
  const auto read_sd = static_cast<float>(sensor.read_noise_grey / 255);
  const double electrons = sensor.full_well_electrons;
  const auto per_electron = static_cast<float>(electrons > 0 ? 1 / electrons : 0);
  const float read_variance = read_sd * read_sd;
  for (int u = 0; u < count; ++u) {
    const float photons = light[u] > 0 ? light[u] : 0;
    light[u] += std::sqrt(read_variance + photons * per_electron) * normals[u];
  }
}

template <typename Pixel>
void quantise(const float* light, Pixel* to, int count, double gain, int bits) {
  const double white = std::exp2(bits) - 1;
  const double scale = gain * white;
  for (int u = 0; u < count; ++u) {
    double level = light[u] * scale;
    level = level > 0 ? level : 0;
    level = level < white ? level : white;
    to[u] = static_cast<Pixel>(static_cast<int>(level + 0.5));
  }
}

// Linear light as IEC 61966-2-1 encodes it, gain applied.
void encode_srgb(const float* light, float* to, int count, double gain) {
  for (int u = 0; u < count; ++u) {
    const double x = std::clamp(gain * light[u], 0.0, 1.0);
    to[u] = static_cast<float>(x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
  }
}

template <typename Pixel>
cv::Mat read_out(const cv::Mat& light, const Sensor& sensor, int type, RandomStream& noise) {
  const bool has_noise = sensor.read_noise_grey > 0 || sensor.full_well_electrons > 0;
  cv::Mat out(light.size(), type);
  std::vector<float> row(light.cols), normals(light.cols);
  for (int v = 0; v < light.rows; ++v) {
    const float* from = light.ptr<float>(v);
    if (has_noise) {
      row.assign(from, from + light.cols);
      noise.normals(normals);
      add_noise(row.data(), normals.data(), light.cols, sensor);
      from = row.data();
    }
    if (sensor.is_srgb) {
      encode_srgb(from, row.data(), light.cols, sensor.gain);
      from = row.data();
    }
    quantise(from, out.ptr<Pixel>(v), light.cols, sensor.is_srgb ? 1 : sensor.gain, sensor.bits);
  }
  return out;
}

// A fixed random order of the pixels: the first of it are dead, the next are hot.
template <typename Pixel>
void add_defects(cv::Mat& image, const Sensor& sensor) {
  const auto pixels = static_cast<double>(image.total());
  const int64_t dead = std::llround(sensor.dead_fraction * pixels);
  const int64_t hot =
      std::min(std::llround(sensor.hot_fraction * pixels), static_cast<long long>(pixels) - dead);
  if (dead + hot == 0) return;
  const auto white = static_cast<Pixel>(std::exp2(sensor.bits) - 1);
  RandomStream stream(sensor.defect_seed, "defects", 0);
  cv::Mat_<uint8_t> is_defect = cv::Mat_<uint8_t>::zeros(image.size());
  for (int64_t done = 0; done < dead + hot;) {
    const auto at = static_cast<int64_t>(stream.uniform() * pixels);
    const int v = static_cast<int>(at / image.cols);
    const int u = static_cast<int>(at % image.cols);
    if (is_defect(v, u) != 0) continue;
    is_defect(v, u) = 1;
    image.at<Pixel>(v, u) = done < dead ? Pixel{0} : white;
    ++done;
  }
}

template <typename Pixel>
cv::Mat exposed(const cv::Mat& linear, const Sensor& sensor, int type, RandomStream& noise) {
  cv::Mat image = read_out<Pixel>(blurred(linear, sensor.psf_sigma_px), sensor, type, noise);
  add_defects<Pixel>(image, sensor);
  return image;
}

}  // namespace

cv::Mat expose(const cv::Mat& linear, const Sensor& sensor, RandomStream noise) {
  return sensor.bits <= 8 ? exposed<uint8_t>(linear, sensor, CV_8U, noise)
                          : exposed<uint16_t>(linear, sensor, CV_16U, noise);
}

}  // namespace sightline
