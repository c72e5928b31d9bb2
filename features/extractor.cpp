// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/extractor.h"

#include <array>

#include <opencv2/core.hpp>

#include "features/extractors/extractors.h"

namespace sightline {
namespace {

constexpr std::array kCatalogue = {
    FeatureExtractor{"hough_intersection",
                     "Canny, Hough, least-squares lines, their intersection (the ORPE paper's)",
                     FeatureKind::kLineIntersection, extract_hough_intersection},
    FeatureExtractor{"shi_tomasi_nearest",
                     "of the Shi-Tomasi corners the one nearest the window's centre (the paper's)",
                     FeatureKind::kCorner, extract_shi_tomasi_nearest},
};

}  // namespace

std::span<const FeatureExtractor> feature_extractors() {
  return kCatalogue;
}

const FeatureExtractor* find_feature_extractor(std::string_view name) {
  for (const FeatureExtractor& extractor : kCatalogue) {
    if (extractor.name == name) return &extractor;
  }
  return nullptr;
}

std::vector<Observation> extract_features(const cv::Mat& image, double white,
                                          std::span<const FeaturePrediction> predictions,
                                          const ExtractorChoice& choice,
                                          const ExtractorOptions& options) {
  cv::Mat grey = image;
  if (image.type() != CV_8U || white != 255) image.convertTo(grey, CV_8U, 255 / white);
  std::vector<Observation> observations;
  for (const FeaturePrediction& prediction : predictions) {
    Observation observation;
    observation.feature = prediction.feature;
    observation.predicted_px = prediction.pixel;
    if (prediction.is_in_front) {
      observation.window = window_around(prediction.pixel, options.window_half_px, grey.size());
    }
    if (observation.window.empty()) {
      observation.status = ObservationStatus::kOutsideImage;
    } else if (prediction.is_hidden) {
      observation.status = ObservationStatus::kHidden;
    } else {
      const bool has_lines = prediction.kind == FeatureKind::kLineIntersection;
      const FeatureExtractor& extractor = has_lines ? *choice.line_intersection : *choice.corner;
      extractor.extract(grey, prediction, options, observation);
    }
    observations.push_back(std::move(observation));
  }
  return observations;
}

}  // namespace sightline
