// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
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

/// Of the extractors that search for a predicted outline along its normals.
struct SearchOptions {
  /// How far from the prediction: so many standard deviations of it and a margin, within limits;
  /// beyond the upper one other edges are more likely to be met than the right one.
  double sigmas = 2.5;
  double margin_px = 1.5;
  double least_half_px = 4;
  double most_half_px = 20;
  /// Where that is no more than this, the prior is good: edges are followed farther and turn less.
  double good_half_px = 5;
  double reach_px = 36;  ///< how far along its edges from a line intersection
  double good_reach_px = 60;
  double max_slope = 0.15;  ///< of a line against its prediction
  double good_max_slope = 0.05;
  double outline_reach_px = 30;  ///< how far along the outline from a feature
  double turn_sd_rad = 0.05;     ///< of an outline against its prediction; none for a good prior
  double noise_sd_grey = 3;      ///< of the image, grey levels of 255, as far as it is known
  double threshold_noises = 5;   ///< an edge's gradient is at least this many times its noise
  double min_contrast_grey = 8;  ///< of target and background, to tell the sides of an edge by
  /// Multiplies what is added to a fit's own sigma for what the fit does not know of; less than 1
  /// where the extractor's bias is removed afterwards.
  double floor_scale = 1;
};

/// Whether lines along the edges of all features are first matched with one pose together
/// (features/joint_edges.h), around which model_edges and edges_else_contour then look. It costs
/// about as much as they do.
enum class JointEdges {
  kTextured,  ///< of targets with textures or vertex colours, whose print may look like edges
  kOn,
  kOff,
};

struct ExtractorOptions {
  int window_half_px = 24;  ///< windows are squares of 2 h + 1 pixels around the prediction
  /// The prior has already been improved from this image: what lies outside the search around its
  /// prediction is not the feature.
  bool is_gated = false;
  JointEdges joint_edges = JointEdges::kTextured;  ///< never where `is_gated`
  LineOptions line;
  CornerOptions corner;
  SearchOptions search;
};

/// All that an extractor is told of one feature. It never sees the truth.
struct ExtractionInput {
  const cv::Mat& image;  ///< CV_8U
  const PredictedView& view;
  const FeaturePrediction& prediction;
  const ExtractorOptions& options;
  /// Where to look: around the prediction, inside the image, not empty and not of one grey. An
  /// extractor that looks elsewhere says so in its observation.
  cv::Rect window;
  /// The median grey level around the target; none where the target fills the image.
  std::optional<double> background_grey;
};

/// Half the width of the search along a unit vector, px, as SearchOptions say.
double search_half_px(const ExtractionInput& input, const Eigen::Vector2d& direction);

/// What an extractor begins with: an observation of the feature asked for, in the window given,
/// that has found nothing (kNoCorner).
Observation nothing_found(const ExtractionInput& input);

/// One way to find a feature in an image near its prediction. To add one: write
/// features/extractors/<name>.cpp with one function of this signature, declare it in
/// features/extractors/extractors.h, and give it a line in the catalogue (features/extractor.cpp).
struct FeatureExtractor {
  std::string_view name;
  std::string_view summary;
  bool needs_edges;  ///< finds line intersections alone; otherwise features of any kind
  /// What it finds, with its covariance and the evidence; or the reason why it finds nothing.
  Observation (*extract)(const ExtractionInput& input);
  bool needs_mesh = false;  ///< of a target of keypoints alone it finds nothing

  bool finds(FeatureKind kind) const {
    return !needs_edges || kind == FeatureKind::kLineIntersection;
  }
};

/// The catalogue, in the order in which it is listed.
std::span<const FeatureExtractor> feature_extractors();

/// The extractor of that name, or null.
const FeatureExtractor* find_feature_extractor(std::string_view name);

/// Which extractor looks for which kind of feature.
struct ExtractorChoice {
  const FeatureExtractor* line_intersection = nullptr;
  const FeatureExtractor* corner = nullptr;
  const FeatureExtractor* contour = nullptr;

  const FeatureExtractor& of(FeatureKind kind) const;
  /// Takes one extractor for all kinds that it finds.
  void choose(const FeatureExtractor& extractor);
};

/// One observation a predicted feature, in their order: features predicted hidden or outside the
/// image are missing observations with that reason; the others are looked for in windows around the
/// predictions. The image is CV_8U or CV_16U (then scaled by its greatest possible value `white`).
/// Of an image in colour (blue, green, red) each window is looked at in its grey, or in the channel
/// in which it has more contrast over noise.
std::vector<Observation> extract_features(const cv::Mat& image, double white,
                                          const PredictedView& view, const ExtractorChoice& choice,
                                          const ExtractorOptions& options);

}  // namespace sightline
