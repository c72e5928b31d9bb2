// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/outline_search.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

namespace sightline {
namespace {

std::optional<uint8_t> grey_at(const cv::Mat& image, const Eigen::Vector2d& pixel) {
  const int u = static_cast<int>(std::lround(pixel.x()));
  const int v = static_cast<int>(std::lround(pixel.y()));
  if (u < 0 || v < 0 || u >= image.cols || v >= image.rows) return std::nullopt;
  return image.at<uint8_t>(v, u);
}

std::optional<double> median(std::vector<uint8_t>& greys) {
  constexpr size_t kFewest = 5;
  if (greys.size() < kFewest) return std::nullopt;
  const auto middle = greys.begin() + static_cast<std::ptrdiff_t>(greys.size() / 2);
  std::nth_element(greys.begin(), middle, greys.end());
  return *middle;
}

// Grey level of the target, on the way from the feature to the middle of its parts.
std::optional<double> inside_level(const ExtractionInput& input) {
  constexpr double kFirstPx = 4;
  constexpr double kLastPx = 22;
  const FeaturePrediction& prediction = input.prediction;
  const FeatureShape& shape = input.view.target->shapes[prediction.feature];
  const auto inside = project(input.view.camera, input.view.cam_from_target * shape.inside_m);
  if (!inside) return std::nullopt;
  const Eigen::Vector2d way = *inside - prediction.pixel;
  const double length_px = way.norm();
  std::vector<uint8_t> greys;
  for (double at = kFirstPx; at <= std::min(kLastPx, length_px); ++at) {
    const auto grey = grey_at(input.image, prediction.pixel + at / length_px * way);
    if (grey) greys.push_back(*grey);
  }
  return median(greys);
}

// Grey level on one side of the outline, where the background lies beyond it.
std::optional<double> side_level(const cv::Mat& image, std::span<const OutlineSample> samples,
                                 double side) {
  std::vector<uint8_t> greys;
  for (const OutlineSample& sample : samples) {
    if (sample.borders_target) continue;
    for (const double at_px : {3.0, 4.5, 6.0}) {
      const auto grey = grey_at(image, sample.pixel + side * at_px * sample.normal);
      if (grey) greys.push_back(*grey);
    }
  }
  return median(greys);
}

}  // namespace

bool is_prior_good(const ExtractionInput& input) {
  return std::max(search_half_px(input, Eigen::Vector2d::UnitX()),
                  search_half_px(input, Eigen::Vector2d::UnitY())) <=
         input.options.search.good_half_px;
}

int search_window_half_px(const ExtractionInput& input) {
  constexpr double kAroundPx = 8;
  const double half_px = std::max(search_half_px(input, Eigen::Vector2d::UnitX()),
                                  search_half_px(input, Eigen::Vector2d::UnitY()));
  return static_cast<int>(std::ceil(half_px + kAroundPx));
}

double gradient_threshold(const SearchOptions& options) {
  constexpr double kLeast = 0.6;  // grey levels a pixel: an edge of two levels
  return std::max(kLeast, options.threshold_noises * kGradientNoise * options.noise_sd_grey);
}

int outline_polarity(const ExtractionInput& input, std::span<const OutlineSample> samples) {
  const SearchOptions& options = input.options.search;
  const bool is_good = is_prior_good(input);
  const std::optional<double> inside =
      is_good ? side_level(input.image, samples, -1) : inside_level(input);
  const std::optional<double> outside =
      is_good ? side_level(input.image, samples, 1) : input.background_grey;
  if (!inside || !outside) return 0;
  const double difference = *outside - *inside;
  if (std::abs(difference) < options.min_contrast_grey) return 0;
  return difference > 0 ? 1 : -1;
}

GradientWindow gradients_around(const ExtractionInput& input,
                                std::span<const OutlineSample> samples) {
  Eigen::AlignedBox2d box;
  for (const OutlineSample& sample : samples) {
    const double half_px = search_half_px(input, sample.normal) + 2;
    box.extend(Eigen::Vector2d(sample.pixel + half_px * sample.normal));
    box.extend(Eigen::Vector2d(sample.pixel - half_px * sample.normal));
  }
  const Eigen::AlignedBox2d image(Eigen::Vector2d(0, 0),
                                  Eigen::Vector2d(input.image.cols - 1, input.image.rows - 1));
  box = box.intersection(image);
  if (box.isEmpty()) return GradientWindow(input.image, {});
  const cv::Point least(static_cast<int>(std::floor(box.min().x())),
                        static_cast<int>(std::floor(box.min().y())));
  const cv::Point most(static_cast<int>(std::ceil(box.max().x())) + 1,
                       static_cast<int>(std::ceil(box.max().y())) + 1);
  return GradientWindow(input.image, cv::Rect(least, most));
}

}  // namespace sightline
