// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "renderer/brdf.h"
#include "renderer/screen.h"

namespace sightline {
namespace {

constexpr double kPi = std::numbers::pi;
const cv::Size kDullSize(64, 32);
constexpr int kMirrorColumns = 1024;  // of what a perfect mirror shows

// Where a direction lies in a panorama, both from 0 to 1.
struct PanoramaPlace {
  double u = 0, v = 0;
};

PanoramaPlace place_of(const Eigen::Vector3d& direction) {
  return {0.5 + std::atan2(direction.x(), direction.z()) / (2 * kPi),
          std::acos(std::clamp(-direction.y(), -1.0, 1.0)) / kPi};
}

Eigen::Vector3d direction_of(double u, double v) {
  const double azimuth = (u - 0.5) * 2 * kPi;
  const double side = std::sin(v * kPi);
  return {side * std::sin(azimuth), -std::cos(v * kPi), side * std::cos(azimuth)};
}

Eigen::Vector3d direction_of_texel(cv::Size size, int column, int row) {
  return direction_of((column + 0.5) / size.width, (row + 0.5) / size.height);
}

// The solid angle of a texel of a row.
double texel_sr(cv::Size size, int row) {
  const double rows = size.height;
  return 2 * kPi / size.width * (std::cos(kPi * row / rows) - std::cos(kPi * (row + 1) / rows));
}

Eigen::Array4f as_light(const cv::Vec3f& texel) {
  return {texel[2], texel[1], texel[0], 0};
}

cv::Vec3f as_texel(const Eigen::Array4d& light) {
  return cv::Vec3f(static_cast<float>(light[2]), static_cast<float>(light[1]),
                   static_cast<float>(light[0]));
}

// The largest whole number that is not greater; `value` is at least -1.
int floor_of(float value) {
  return static_cast<int>(value + 1) - 1;
}

// Bilinear; the columns close to a ring, and beyond a pole is the last row.
Eigen::Array4f look_up(const cv::Mat& map, const PanoramaPlace& place) {
  using Texel = Eigen::Map<const Eigen::Array3f>;  // blue, green, red
  const auto x = static_cast<float>(place.u * map.cols - 0.5);
  const auto y = static_cast<float>(place.v * map.rows - 0.5);
  const int left = floor_of(x);
  const int top = floor_of(y);
  const float right_share = x - static_cast<float>(left);
  const float low_share = y - static_cast<float>(top);
  const int columns[] = {left < 0 ? map.cols - 1 : left, left + 1 < map.cols ? left + 1 : 0};
  const auto row_light = [&](int row) -> Eigen::Array3f {
    const cv::Vec3f* texels = map.ptr<cv::Vec3f>(std::clamp(row, 0, map.rows - 1));
    return (1 - right_share) * Texel(texels[columns[0]].val) +
           right_share * Texel(texels[columns[1]].val);
  };
  const Eigen::Array3f light = (1 - low_share) * row_light(top) + low_share * row_light(top + 1);
  return {light[2], light[1], light[0], 0};
}

// Means by solid angle.
cv::Mat resized(const cv::Mat& map, cv::Size size) {
  if (size.width >= map.cols) {
    cv::Mat larger;
    cv::resize(map, larger, size, 0, 0, cv::INTER_NEAREST);
    return larger;
  }
  cv::Mat weighed = map.clone();
  cv::Mat weights(map.rows, 1, CV_32F);
  for (int row = 0; row < map.rows; ++row) {
    const auto weight = static_cast<float>(std::sin((row + 0.5) / map.rows * kPi));
    weights.at<float>(row) = weight;
    weighed.row(row) *= weight;
  }
  cv::Mat smaller, sums;
  cv::resize(weighed, smaller, size, 0, 0, cv::INTER_AREA);
  cv::resize(weights, sums, {1, size.height}, 0, 0, cv::INTER_AREA);
  for (int row = 0; row < size.height; ++row) smaller.row(row) *= 1 / sums.at<float>(row);
  return smaller;
}

// A direction of light about a mirror's direction, both as the mirror's normal has them.
struct GlossySample {
  Eigen::Vector3d to_light;  // z along the normal
  double weight = 0;
  double solid_angle = 0;  // that it stands for
};

// Half-way directions as microfacets are frequent, seen along the normal.
std::vector<GlossySample> glossy_samples(double a) {
  constexpr uint32_t kCount = 64;
  std::vector<GlossySample> samples;
  for (uint32_t i = 0; i < kCount; ++i) {
    const double azimuth = 2 * kPi * (i + 0.5) / kCount;
    const double x = radical_inverse(i) + 0.5 / kCount;
    const double n_h = std::sqrt((1 - x) / (1 + (a * a - 1) * x));
    const double n_l = 2 * n_h * n_h - 1;
    if (!(n_l > 0)) continue;
    const double side = std::sqrt(std::max(0.0, 1 - n_l * n_l));
    const double root = n_h * n_h * (a * a - 1) + 1;
    const double density = a * a / (kPi * root * root) / 4;  // of lights: D n_h over 4 v_h
    samples.push_back(
        {{side * std::cos(azimuth), side * std::sin(azimuth), n_l}, n_l, 1 / (kCount * density)});
  }
  return samples;
}

// Columns: two axes across a direction, and itself.
Eigen::Matrix3d axes_about(const Eigen::Vector3d& direction) {
  Eigen::Matrix3d axes;
  axes.col(0) = direction.unitOrthogonal();
  axes.col(1) = direction.cross(axes.col(0));
  axes.col(2) = direction;
  return axes;
}

}  // namespace

EnvironmentLight::EnvironmentLight(std::shared_ptr<const cv::Mat> panorama)
    : panorama_(std::move(panorama)) {
  levels_.push_back(*panorama_);
  while (levels_.back().rows > 1) {
    const cv::Mat& last = levels_.back();
    levels_.push_back(resized(last, {last.cols / 2, last.rows / 2}));
  }
  dull_ = dull_map();
}

cv::Mat EnvironmentLight::mirror_map() const {
  return *std::find_if(levels_.begin(), levels_.end(),
                       [](const cv::Mat& level) { return level.cols <= kMirrorColumns; });
}

const cv::Mat& EnvironmentLight::glossy_of(size_t step) {
  cv::Mat& map = glossy_[step];
  if (!map.empty()) return map;
  // As fine as the blur leaves anything to see.
  const int columns = step == 1 ? 256 : step <= 3 ? 128 : 64;
  map = step == 0 ? mirror_map()
                  : glossy_map(static_cast<double>(step) / kRoughnesses, {columns, columns / 2});
  return map;
}

cv::Mat EnvironmentLight::dull_map() const {
  const cv::Mat source = resized(levels_.front(), kDullSize);
  struct Far {
    Eigen::Vector3d direction;
    Eigen::Array4d light;
    double solid_angle;
  };
  std::vector<Far> texels;
  for (int row = 0; row < source.rows; ++row) {
    for (int column = 0; column < source.cols; ++column) {
      texels.push_back({direction_of_texel(source.size(), column, row),
                        as_light(source.at<cv::Vec3f>(row, column)).cast<double>(),
                        texel_sr(source.size(), row)});
    }
  }
  cv::Mat out(kDullSize, CV_32FC3);
  for (int row = 0; row < out.rows; ++row) {
    for (int column = 0; column < out.cols; ++column) {
      const Eigen::Vector3d normal = direction_of_texel(out.size(), column, row);
      Eigen::Array4d sum = Eigen::Array4d::Zero();
      double weights = 0;
      for (const Far& texel : texels) {
        const double weight = texel.solid_angle * std::max(0.0, normal.dot(texel.direction));
        sum += weight * texel.light;
        weights += weight;
      }
      out.at<cv::Vec3f>(row, column) = as_texel(sum / weights);
    }
  }
  return out;
}

cv::Mat EnvironmentLight::glossy_map(double roughness, cv::Size size) const {
  const std::vector<GlossySample> samples = glossy_samples(roughness * roughness);
  const double finest_sr = 4 * kPi / static_cast<double>(levels_.front().total());
  cv::Mat out(size, CV_32FC3);
  for (int row = 0; row < out.rows; ++row) {
    for (int column = 0; column < out.cols; ++column) {
      const Eigen::Matrix3d axes = axes_about(direction_of_texel(size, column, row));
      Eigen::Array4d sum = Eigen::Array4d::Zero();
      double weights = 0;
      for (const GlossySample& sample : samples) {
        const double level = std::log2(sample.solid_angle / finest_sr) / 2;
        sum += sample.weight * at_level(axes * sample.to_light, level).cast<double>();
        weights += sample.weight;
      }
      out.at<cv::Vec3f>(row, column) = as_texel(sum / weights);
    }
  }
  return out;
}

Eigen::Array4f EnvironmentLight::at_level(const Eigen::Vector3d& direction, double level) const {
  const PanoramaPlace place = place_of(direction);
  const double held = std::clamp(level, 0.0, static_cast<double>(levels_.size() - 1));
  const auto fine = static_cast<size_t>(held);
  const auto share = static_cast<float>(held - static_cast<double>(fine));
  const Eigen::Array4f finer = look_up(levels_[fine], place);
  if (!(share > 0)) return finer;
  return (1 - share) * finer + share * look_up(levels_[fine + 1], place);
}

Eigen::Array4f EnvironmentLight::seen(const Eigen::Vector3d& direction, double pixel_rad) const {
  return at_level(direction, std::log2(pixel_rad * levels_.front().cols / (2 * kPi)));
}

Eigen::Array4f EnvironmentLight::dull(const Eigen::Vector3d& normal) const {
  return look_up(dull_, place_of(normal));
}

Eigen::Array4f EnvironmentLight::glossy(const Eigen::Vector3d& direction, double roughness) {
  const PanoramaPlace place = place_of(direction);
  const double at = std::clamp(roughness, 0.0, 1.0) * kRoughnesses;
  const auto low = std::min(static_cast<size_t>(at), size_t{kRoughnesses - 1});
  const auto share = static_cast<float>(at - static_cast<double>(low));
  const Eigen::Array4f smoother = look_up(glossy_of(low), place);
  if (!(share > 0)) return smoother;
  return (1 - share) * smoother + share * look_up(glossy_of(low + 1), place);
}

cv::Mat environment_image(const EnvironmentLight& light, const Environment& environment,
                          const Camera& camera) {
  const Screen screen(camera, {0, 0, camera.width_px, camera.height_px}, 1);
  const Eigen::Matrix3d environment_from_cam = cam_from_environment(environment).transpose();
  const double pixel_rad = 1 / std::max(camera.fx_px, camera.fy_px);
  const auto strength = static_cast<float>(environment.strength);
  cv::Mat image(camera.height_px, camera.width_px, CV_32FC3);
  for (int v = 0; v < image.rows; ++v) {
    cv::Vec3f* row = image.ptr<cv::Vec3f>(v);
    for (int u = 0; u < image.cols; ++u) {
      const Eigen::Vector2d at =
          screen.normalised({static_cast<double>(u), static_cast<double>(v)});
      const Eigen::Vector3d ray = Eigen::Vector3d(at.x(), at.y(), 1).normalized();
      const Eigen::Array4f seen = strength * light.seen(environment_from_cam * ray, pixel_rad);
      row[u] = {seen[2], seen[1], seen[0]};
    }
  }
  return image;
}

}  // namespace sightline
