// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "features/observation.h"
#include "features/prediction.h"

namespace sightline {

struct LineOptions {
  double direction_tolerance_deg = 10;  ///< a line may turn this far from the predicted edge
  int min_votes = 8;                    ///< of edge pixels in the Hough transform
  int min_edge_pixels = 6;              ///< that agree with the line in the end
  double min_angle_deg = 12;            ///< between the two lines
  double canny_low = 40;                ///< hysteresis, in Sobel units of an 8-bit image
  double canny_high = 100;
};

struct CornerOptions {
  int max_corners = 12;
  double quality = 0.05;          ///< of the best corner's smaller eigenvalue
  double min_contrast_grey = 12;  ///< of the weaker edge at the corner, grey levels of 255
  double min_distance_px = 3;     ///< between corners
  int block_px = 5;               ///< the window of the structure tensor
};

struct ExtractorOptions {
  int window_half_px = 24;  ///< windows are squares of 2 h + 1 pixels around the prediction
  LineOptions line;
  CornerOptions corner;
};

/// One way to find a feature in an image near its prediction. To add one: write
/// features/extractors/<name>.cpp with one function of this signature, declare it in
/// features/extractors/extractors.h, and give it a line in the catalogue (features/extractor.cpp).
struct FeatureExtractor {
  std::string_view name;
  std::string_view summary;
  FeatureKind kind;  ///< of the features it finds
  /// `image` is CV_8U; the window lies inside it. Fills status, pixel, covariance and evidence.
  void (*extract)(const cv::Mat& image, const FeaturePrediction& prediction,
                  const ExtractorOptions& options, Observation& observation);
};

/// The catalogue, in the order in which it is listed.
std::span<const FeatureExtractor> feature_extractors();

/// The extractor of that name, or null.
const FeatureExtractor* find_feature_extractor(std::string_view name);

/// Which extractor looks for which kind of feature.
struct ExtractorChoice {
  const FeatureExtractor* line_intersection = nullptr;
  const FeatureExtractor* corner = nullptr;
};

/// One observation a prediction, in its order: features predicted hidden or outside the image are
/// missing observations with that reason; the others are looked for in windows around the
/// predictions. The image is CV_8U or CV_16U (then scaled by its greatest possible value `white`).
std::vector<Observation> extract_features(const cv::Mat& image, double white,
                                          std::span<const FeaturePrediction> predictions,
                                          const ExtractorChoice& choice,
                                          const ExtractorOptions& options);

}  // namespace sightline
