// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/prediction.h"

#include <cmath>

namespace sightline {
namespace {

// The image direction of an edge at its beginning: the derivative of the projection along it.
// A far end point would do as well, but may lie behind the camera.
Eigen::Vector2d image_direction(const Camera& camera, const Pose& cam_from_target,
                                const Edge& edge) {
  const Eigen::Vector3d x = cam_from_target * edge.begin_m;
  const Eigen::Vector3d d = cam_from_target.rotation * (edge.end_m - edge.begin_m);
  const Eigen::Vector2d direction(camera.fx_px * (d.x() * x.z() - x.x() * d.z()),
                                  camera.fy_px * (d.y() * x.z() - x.y() * d.z()));
  return direction.norm() > 0 ? Eigen::Vector2d(direction.normalized()) : Eigen::Vector2d::UnitX();
}

}  // namespace

std::vector<FeaturePrediction> predict_features(const Target& target, std::span<const int> features,
                                                const Camera& camera,
                                                const Pose& prior_cam_from_target) {
  std::vector<FeaturePrediction> predictions;
  for (const int index : features) {
    const TargetFeature& feature = target.features[index];
    FeaturePrediction prediction;
    prediction.feature = index;
    prediction.kind = feature.kind;
    const auto pixel = project(camera, prior_cam_from_target * feature.position_m);
    prediction.is_in_front = pixel.has_value();
    if (pixel) {
      prediction.pixel = *pixel;
      prediction.is_hidden = is_self_hidden(target, feature, prior_cam_from_target);
      if (feature.kind == FeatureKind::kLineIntersection) {
        for (int i = 0; i < 2; ++i) {
          prediction.edge_direction[i] =
              image_direction(camera, prior_cam_from_target, feature.edges[i]);
        }
      }
    }
    predictions.push_back(prediction);
  }
  return predictions;
}

cv::Rect window_around(const Eigen::Vector2d& pixel, int half_px, const cv::Size& image) {
  // Far outside is outside: keeps the rounding below within int.
  if (!(pixel.cwiseAbs().maxCoeff() < 1e6)) return {};
  const int u = static_cast<int>(std::lround(pixel.x()));
  const int v = static_cast<int>(std::lround(pixel.y()));
  const cv::Rect whole(u - half_px, v - half_px, 2 * half_px + 1, 2 * half_px + 1);
  const cv::Rect window = whole & cv::Rect({0, 0}, image);
  return 2 * window.area() >= whole.area() ? window : cv::Rect();
}

}  // namespace sightline
