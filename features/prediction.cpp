// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/prediction.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "pose/angles.h"

namespace sightline {
namespace {

// The derivative of the pixel by the point.
Eigen::Matrix<double, 2, 3> pixel_by_point(const Camera& camera, const Eigen::Vector3d& x_in_cam) {
  const double z = x_in_cam.z();
  Eigen::Matrix<double, 2, 3> jacobian;
  jacobian << camera.fx_px / z, 0, -camera.fx_px * x_in_cam.x() / (z * z), 0, camera.fy_px / z,
      -camera.fy_px * x_in_cam.y() / (z * z);
  if (is_straight(camera)) return jacobian;
  return lens_jacobian(camera, x_in_cam.head<2>() / z) * jacobian;
}

// How well an edge is seen: its length in the image, up to what an extractor looks at; nothing
// where the target hides it.
double seen_length_px(const Target& target, const Edge& edge, const Camera& camera,
                      const Pose& cam_from_target, double clearance_m) {
  constexpr double kLongEnoughPx = 36;
  const Eigen::Vector3d eye_in_target = inverse(cam_from_target).translation;
  for (const double t : {0.15, 0.4}) {
    const Eigen::Vector3d point = edge.begin_m + t * (edge.end_m - edge.begin_m);
    if (target.occluder.hides_own(point, eye_in_target, clearance_m)) return 0;
  }
  const auto begin = project(camera, cam_from_target * edge.begin_m);
  const auto end = project(camera, cam_from_target * edge.end_m);
  if (!begin || !end) return 0;
  return std::min(kLongEnoughPx, (*end - *begin).norm());
}

// The two edges that are long in the image and meet there at a wide angle.
std::array<int, 2> best_seen(const Target& target, const TargetFeature& feature,
                             const Camera& camera, const Pose& cam_from_target) {
  const int count = static_cast<int>(feature.edges.size());
  std::array<int, 2> best{0, 1};
  if (count <= 2) return best;
  std::vector<double> lengths_px;
  std::vector<Eigen::Vector2d> directions;
  for (const Edge& edge : feature.edges) {
    lengths_px.push_back(
        seen_length_px(target, edge, camera, cam_from_target, feature.clearance_m));
    directions.push_back(image_direction(camera, cam_from_target, edge));
  }
  double greatest = 0;
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j < count; ++j) {
      const double sine =
          std::abs(directions[i].x() * directions[j].y() - directions[i].y() * directions[j].x());
      const double value = sine * std::min(lengths_px[i], lengths_px[j]);
      if (value <= greatest) continue;
      greatest = value;
      best = {i, j};
    }
  }
  return best;
}

}  // namespace

double predicted_sd_px(const FeaturePrediction& prediction) {
  return std::sqrt(prediction.covariance_px2.trace() / 2);
}

// The derivative of the projection along the edge. A far end point would do as well, but may lie
// behind the camera.
Eigen::Vector2d image_direction(const Camera& camera, const Pose& cam_from_target,
                                const Edge& edge) {
  const Eigen::Vector3d x = cam_from_target * edge.begin_m;
  const Eigen::Vector3d d = cam_from_target.rotation * (edge.end_m - edge.begin_m);
  Eigen::Vector2d direction(camera.fx_px * (d.x() * x.z() - x.x() * d.z()),
                            camera.fy_px * (d.y() * x.z() - x.y() * d.z()));
  if (!is_straight(camera)) {
    direction = (lens_jacobian(camera, x.head<2>() / x.z()) * direction).eval();
  }
  return direction.norm() > 0 ? Eigen::Vector2d(direction.normalized()) : Eigen::Vector2d::UnitX();
}

PosePrior prior_of(const Pose& cam_from_target, const Camera& camera, const PriorError& error) {
  const Eigen::Vector3d& t = cam_from_target.translation;
  const double angle = error.attitude_deg * kDegree;
  const double across_x = error.lateral_px * t.z() / camera.fx_px;
  const double across_y = error.lateral_px * t.z() / camera.fy_px;
  PosePrior prior{cam_from_target, Matrix6d::Zero()};
  prior.covariance.topLeftCorner<3, 3>().diagonal().setConstant(angle * angle);
  prior.covariance.bottomRightCorner<3, 3>() =
      error.range_fraction * error.range_fraction * t * t.transpose();
  prior.covariance(3, 3) += across_x * across_x;
  prior.covariance(4, 4) += across_y * across_y;
  return prior;
}

Eigen::Matrix2d predicted_covariance_px2(const Camera& camera, const PosePrior& prior,
                                         const Eigen::Vector3d& position_m) {
  const Eigen::Vector3d arm = prior.cam_from_target.rotation * position_m;
  const Eigen::Vector3d x_in_cam = arm + prior.cam_from_target.translation;
  if (!(x_in_cam.z() > 0)) return Eigen::Matrix2d::Zero();
  Eigen::Matrix<double, 3, 6> point_by_pose;
  // w x arm = -[arm]x w.
  point_by_pose << 0, arm.z(), -arm.y(), 1, 0, 0, -arm.z(), 0, arm.x(), 0, 1, 0, arm.y(), -arm.x(),
      0, 0, 0, 1;
  const Eigen::Matrix<double, 2, 6> jacobian = pixel_by_point(camera, x_in_cam) * point_by_pose;
  return jacobian * prior.covariance * jacobian.transpose();
}

PredictedView predict_features(const Target& target, std::span<const int> features,
                               const Camera& camera, const PosePrior& prior) {
  const Pose& cam_from_target = prior.cam_from_target;
  PredictedView view{&target, camera, cam_from_target, {}, prior.covariance};
  for (const int index : features) {
    const TargetFeature& feature = target.features[index];
    FeaturePrediction prediction;
    prediction.feature = index;
    prediction.kind = feature.kind;
    const auto pixel = project(camera, cam_from_target * feature.position_m);
    prediction.is_in_front = pixel.has_value();
    if (pixel) {
      prediction.pixel = *pixel;
      prediction.covariance_px2 = predicted_covariance_px2(camera, prior, feature.position_m);
      prediction.is_hidden = is_self_hidden(target, feature, cam_from_target);
      if (feature.kind == FeatureKind::kLineIntersection) {
        prediction.edge = best_seen(target, feature, camera, cam_from_target);
        for (int i = 0; i < 2; ++i) {
          prediction.edge_direction[i] =
              image_direction(camera, cam_from_target, feature.edges[prediction.edge[i]]);
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
