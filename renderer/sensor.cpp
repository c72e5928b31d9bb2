// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/sensor.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "scenes/mesh/textures.h"

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
    to[u] = static_cast<float>(srgb_from_linear(std::clamp(gain * light[u], 0.0, 1.0)));
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

// What the lens loses towards the corners.
cv::Mat vignetted(const cv::Mat& linear, double loss) {
  if (!(loss > 0)) return linear;
  const double middle_u = (linear.cols - 1) / 2.0;
  const double middle_v = (linear.rows - 1) / 2.0;
  const double corner = middle_u * middle_u + middle_v * middle_v;
  const int channels = linear.channels();
  cv::Mat out = linear.clone();
  for (int v = 0; v < out.rows; ++v) {
    float* row = out.ptr<float>(v);
    for (int u = 0; u < out.cols; ++u) {
      const double square = (u - middle_u) * (u - middle_u) + (v - middle_v) * (v - middle_v);
      const auto left = static_cast<float>(corner > 0 ? 1 - loss * square / corner : 1);
      for (int c = 0; c < channels; ++c) row[u * channels + c] *= left;
    }
  }
  return out;
}

// What each channel reads of the light, blue, green and red: its row of the response.
cv::Mat as_read(const cv::Mat& linear, const Sensor& sensor) {
  if (sensor.response == Sensor{}.response) return linear;
  cv::Matx33d rows;
  for (int to = 0; to < 3; ++to) {
    for (int from = 0; from < 3; ++from) rows(to, from) = sensor.response(2 - to, 2 - from);
  }
  cv::Mat out;
  cv::transform(linear, out, rows);
  return out;
}

cv::Mat exposed(const cv::Mat& linear, const Sensor& sensor, RandomStream& noise) {
  return sensor.bits <= 8 ? exposed<uint8_t>(linear, sensor, CV_8U, noise)
                          : exposed<uint16_t>(linear, sensor, CV_16U, noise);
}

// Three sensors behind one lens, blue, green and red: each has noise of its own, red's first, and
// all have their defects at the same pixels.
std::vector<cv::Mat> exposed_channels(const cv::Mat& linear, const Sensor& sensor,
                                      RandomStream& noise) {
  std::vector<cv::Mat> channels;
  cv::split(as_read(linear, sensor), channels);
  for (size_t c = channels.size(); c-- > 0;) {
    Sensor own = sensor;
    own.gain *= sensor.white_balance[2 - static_cast<Eigen::Index>(c)];
    channels[c] = exposed(channels[c], own, noise);
  }
  return channels;
}

// Of each pixel the one channel that its photosite sees.
template <typename Pixel>
cv::Mat mosaic_of(const std::vector<cv::Mat>& channels) {
  cv::Mat mosaic(channels[0].size(), channels[0].type());
  for (int v = 0; v < mosaic.rows; ++v) {
    for (int u = 0; u < mosaic.cols; ++u) {
      const size_t channel = 2 - static_cast<size_t>(u % 2 + v % 2);  // red, green / green, blue
      mosaic.at<Pixel>(v, u) = channels[channel].at<Pixel>(v, u);
    }
  }
  return mosaic;
}

template <typename Pixel>
void encode_srgb_codes(cv::Mat& image, int bits) {
  const double white = std::exp2(bits) - 1;
  std::vector<Pixel> code_of(static_cast<size_t>(white) + 1);
  for (size_t code = 0; code < code_of.size(); ++code) {
    const auto light = static_cast<float>(static_cast<double>(code) / white);
    float encoded = 0;
    encode_srgb(&light, &encoded, 1, 1);
    code_of[code] = static_cast<Pixel>(std::lround(encoded * white));
  }
  const int count = image.cols * image.channels();
  for (int v = 0; v < image.rows; ++v) {
    Pixel* row = image.ptr<Pixel>(v);
    // Codes of fewer bits than the pixel has stay below white.
    for (int i = 0; i < count; ++i) row[i] = code_of[std::min<size_t>(row[i], code_of.size() - 1)];
  }
}

}  // namespace

cv::Mat expose(const cv::Mat& linear, const Sensor& sensor, RandomStream noise) {
  const cv::Mat light = vignetted(linear, sensor.vignetting);
  if (light.channels() == 1) return exposed(light, sensor, noise);
  cv::Mat image;
  cv::merge(exposed_channels(light, sensor, noise), image);
  return image;
}

cv::Mat expose_mosaic(const cv::Mat& linear, const Sensor& sensor, RandomStream noise) {
  Sensor photosites = sensor;
  photosites.is_srgb = false;
  const std::vector<cv::Mat> channels =
      exposed_channels(vignetted(linear, sensor.vignetting), photosites, noise);
  const bool is_wide = sensor.bits > 8;
  const cv::Mat mosaic = is_wide ? mosaic_of<uint16_t>(channels) : mosaic_of<uint8_t>(channels);
  cv::Mat image;
  cv::demosaicing(mosaic, image, cv::COLOR_BayerRGGB2BGR);
  if (sensor.is_srgb && is_wide) encode_srgb_codes<uint16_t>(image, sensor.bits);
  if (sensor.is_srgb && !is_wide) encode_srgb_codes<uint8_t>(image, sensor.bits);
  return image;
}

}  // namespace sightline
