// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/prediction.h"

#include <cmath>
#include <numbers>

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

// What draw_prior's errors make of a pixel, to first order and for a target whose depth is small
// against its distance.
Eigen::Matrix2d pixel_covariance_px2(const Camera& camera, const Pose& cam_from_target,
                                     const Eigen::Vector3d& position_m, const PriorError& error) {
  constexpr double kDegree = std::numbers::pi / 180;
  const Eigen::Vector3d arm_m = cam_from_target.rotation * position_m;
  const double z_m = cam_from_target.translation.z() + arm_m.z();
  const Eigen::Vector3d arm_px = arm_m.cwiseProduct(
      Eigen::Vector3d(camera.fx_px, camera.fy_px, (camera.fx_px + camera.fy_px) / 2) / z_m);
  const Eigen::Vector2d in_image = arm_px.head<2>();
  const Eigen::Vector2d across(in_image.y(), -in_image.x());
  const double angle = error.attitude_deg * kDegree;
  const double lateral = error.lateral_px;
  return angle * angle *
             (arm_px.z() * arm_px.z() * Eigen::Matrix2d::Identity() + across * across.transpose()) +
         error.range_fraction * error.range_fraction * in_image * in_image.transpose() +
         lateral * lateral * Eigen::Matrix2d::Identity();
}

}  // namespace

PredictedView predict_features(const Target& target, std::span<const int> features,
                               const Camera& camera, const Pose& prior_cam_from_target,
                               const PriorError& error) {
  PredictedView view{&target, camera, prior_cam_from_target, {}};
  for (const int index : features) {
    const TargetFeature& feature = target.features[index];
    FeaturePrediction prediction;
    prediction.feature = index;
    prediction.kind = feature.kind;
    const auto pixel = project(camera, prior_cam_from_target * feature.position_m);
    prediction.is_in_front = pixel.has_value();
    if (pixel) {
      prediction.pixel = *pixel;
      prediction.covariance_px2 =
          pixel_covariance_px2(camera, prior_cam_from_target, feature.position_m, error);
      prediction.is_hidden = is_self_hidden(target, feature, prior_cam_from_target);
      if (feature.kind == FeatureKind::kLineIntersection) {
        for (int i = 0; i < 2; ++i) {
          prediction.edge_direction[i] =
              image_direction(camera, prior_cam_from_target, feature.edges[i]);
        }
      }
    }
    view.features.push_back(prediction);
  }
  return view;
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
