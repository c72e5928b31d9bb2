// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/scene.h"
#include "scenes/target.h"

namespace sightline {

/// Where a prior pose expects a feature. It never sees the truth.
struct FeaturePrediction {
  int feature = 0;  ///< index into the target's features
  FeatureKind kind = FeatureKind::kCorner;
  bool is_in_front = false;  ///< of the camera; else nothing below is meaningful
  bool is_hidden = false;    ///< by the target's own mesh
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();  ///< that the prior's error leaves
  /// For line intersections: unit vectors in the image along the two edges, away from the feature.
  std::array<Eigen::Vector2d, 2> edge_direction{Eigen::Vector2d::UnitX(), Eigen::Vector2d::UnitY()};
};

/// The target as a prior pose expects it: all that an extractor may know.
struct PredictedView {
  const Target* target = nullptr;  ///< must outlive this; without it there are no outlines
  Camera camera;
  Pose cam_from_target;
  std::vector<FeaturePrediction> features;
};

/// The view of those features of a target. `error` is how far the prior pose may be off.
PredictedView predict_features(const Target& target, std::span<const int> features,
                               const Camera& camera, const Pose& prior_cam_from_target,
                               const PriorError& error = {});

/// The square window of half-size `half_px` around the pixel, cut at the image's border; empty
/// where less than half of it lies on the image.
cv::Rect window_around(const Eigen::Vector2d& pixel, int half_px, const cv::Size& image);

}  // namespace sightline
