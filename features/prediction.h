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
#include "pose/solver.h"
#include "scenes/scene/prior.h"
#include "scenes/target/target.h"

namespace sightline {

/// Where a prior pose expects a feature. It never sees the truth.
struct FeaturePrediction {
  int feature = 0;  ///< index into the target's features
  FeatureKind kind = FeatureKind::kCorner;
  bool is_in_front = false;  ///< of the camera; else nothing below is meaningful
  bool is_hidden = false;    ///< by the target's own mesh
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();  ///< that the prior's error leaves
  /// For line intersections: the two of the feature's edges that are best seen, and unit vectors in
  /// the image along them, away from the feature.
  std::array<int, 2> edge{0, 1};
  std::array<Eigen::Vector2d, 2> edge_direction{Eigen::Vector2d::UnitX(), Eigen::Vector2d::UnitY()};
};

/// The standard deviation of a predicted pixel in one coordinate, px: of u and v the mean square.
double predicted_sd_px(const FeaturePrediction& prediction);

/// The target as a prior pose expects it: all that an extractor may know.
struct PredictedView {
  const Target* target = nullptr;  ///< must outlive this; without it there are no outlines
  Camera camera;
  Pose cam_from_target;
  std::vector<FeaturePrediction> features;
  /// Of cam_from_target, as PosePrior has it; zero where it is not known.
  Matrix6d covariance = Matrix6d::Zero();
};

/// A pose as it is known before an image is looked at.
struct PosePrior {
  Pose cam_from_target;
  /// Of (w, dt): the truth is (Exp(w) R, t + dt); radians and metres.
  Matrix6d covariance = Matrix6d::Zero();
};

/// A pose that errs as draw_prior makes it.
PosePrior prior_of(const Pose& cam_from_target, const Camera& camera, const PriorError& error);

/// To first order the covariance that the prior leaves of the pixel of a point of the target; zero
/// for a point behind the camera.
Eigen::Matrix2d predicted_covariance_px2(const Camera& camera, const PosePrior& prior,
                                         const Eigen::Vector3d& position_m);

/// The direction, a unit vector, in which an edge leaves its beginning in the image.
Eigen::Vector2d image_direction(const Camera& camera, const Pose& cam_from_target,
                                const Edge& edge);

/// The view of those features of a target.
PredictedView predict_features(const Target& target, std::span<const int> features,
                               const Camera& camera, const PosePrior& prior);

/// The square window of half-size `half_px` around the pixel, cut at the image's border; empty
/// where less than half of it lies on the image.
cv::Rect window_around(const Eigen::Vector2d& pixel, int half_px, const cv::Size& image);

}  // namespace sightline
