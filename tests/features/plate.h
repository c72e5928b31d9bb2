// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A bright square plate before a camera, and its image by exact area coverage: what the extractors
// are measured on without any renderer.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Core>
#include <opencv2/imgproc.hpp>

#include "features/extractor.h"
#include "pose/angles.h"
#include "scenes/random/random.h"

namespace sightline {

inline constexpr int kPlateImagePx = 161;
inline constexpr double kPlateHalfM = 5;  // 50 px

inline Camera plate_camera() {
  return centred_camera(kPlateImagePx, kPlateImagePx, 1000);
}

/// Facing the camera at the identity attitude; its features are its four corners, as line
/// intersections.
inline Target plate_target() {
  Mesh mesh;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    mesh.vertices.emplace_back(kPlateHalfM * x, kPlateHalfM * y, 0);
  }
  const Eigen::Vector3d normal = -Eigen::Vector3d::UnitZ();
  mesh.triangles = {{{0, 3, 2}, 0, {normal, normal, normal}},
                    {{0, 2, 1}, 0, {normal, normal, normal}}};
  mesh.parts = {{"plate", 0.8}};
  std::vector<TargetFeature> features(4);
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d corner = mesh.vertices[i];
    features[i].name = std::to_string(i);
    features[i].kind = FeatureKind::kLineIntersection;
    features[i].position_m = corner;
    features[i].edges = {{corner, mesh.vertices[(i + 1) % 4]},
                         {corner, mesh.vertices[(i + 3) % 4]}};
  }
  std::vector<FeatureShape> shapes = feature_shapes(mesh, features);
  Occluder occluder(mesh);
  return {"plate",          "", std::move(mesh), {}, std::move(features), std::move(occluder),
          std::move(shapes)};
}

inline Pose plate_pose(double roll_deg, const Eigen::Vector2d& shift_m = Eigen::Vector2d::Zero()) {
  const double roll = roll_deg * kDegree;
  return {rotation_from_vector({0, 0, roll}), {shift_m.x(), shift_m.y(), 100}};
}

/// The area of a convex polygon (either way round) within each pixel.
inline cv::Mat coverage(const std::vector<Eigen::Vector2d>& polygon, int size_px) {
  double twice_area = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    twice_area += a.x() * b.y() - a.y() * b.x();
  }
  const double sense = twice_area > 0 ? 1 : -1;
  cv::Mat image(size_px, size_px, CV_32F);
  std::vector<Eigen::Vector2d> piece, clipped;
  for (int v = 0; v < size_px; ++v) {
    for (int u = 0; u < size_px; ++u) {
      piece = {{u - 0.5, v - 0.5}, {u + 0.5, v - 0.5}, {u + 0.5, v + 0.5}, {u - 0.5, v + 0.5}};
      for (size_t i = 0; i < polygon.size() && !piece.empty(); ++i) {
        const Eigen::Vector2d& a = polygon[i];
        const Eigen::Vector2d along = polygon[(i + 1) % polygon.size()] - a;
        const auto inside = [&](const Eigen::Vector2d& p) {
          return sense * (along.x() * (p - a).y() - along.y() * (p - a).x());
        };
        clipped.clear();
        for (size_t j = 0; j < piece.size(); ++j) {
          const Eigen::Vector2d& p = piece[j];
          const Eigen::Vector2d& q = piece[(j + 1) % piece.size()];
          const double from = inside(p);
          const double to = inside(q);
          if (from >= 0) clipped.push_back(p);
          if (from * to < 0) clipped.push_back(p + from / (from - to) * (q - p));
        }
        piece.swap(clipped);
      }
      double area = 0;
      for (size_t j = 0; j < piece.size(); ++j) {
        const Eigen::Vector2d& p = piece[j];
        const Eigen::Vector2d& q = piece[(j + 1) % piece.size()];
        area += (p.x() * q.y() - p.y() * q.x()) / 2;
      }
      image.at<float>(v, u) = static_cast<float>(std::abs(area));
    }
  }
  return image;
}

struct PlateImage {
  double inside = 180;
  double outside = 40;
  double blur_px = 0.7;
  double noise_grey = 3;
  uint64_t index = 0;  ///< of the noise
};

inline cv::Mat plate_coverage(const Pose& pose) {
  std::vector<Eigen::Vector2d> corners;
  for (const TargetFeature& feature : plate_target().features) {
    corners.push_back(*project(plate_camera(), pose * feature.position_m));
  }
  return coverage(corners, kPlateImagePx);
}

/// Light from 0 (outside) to 1 (inside) as a sensor sees it.
inline cv::Mat exposed(const cv::Mat& light, const PlateImage& how) {
  cv::Mat image = light.clone();
  if (how.blur_px > 0) cv::GaussianBlur(image, image, {13, 13}, how.blur_px);
  RandomStream stream(1, "noise", how.index);
  image.forEach<float>([&](float& value, const int*) {
    value = static_cast<float>(how.outside + (how.inside - how.outside) * value);
  });
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      image.at<float>(v, u) += static_cast<float>(how.noise_grey * stream.normal());
    }
  }
  image.convertTo(image, CV_8U);
  return image;
}

/// What an extractor by that name makes of the plate's corners.
inline std::vector<Observation> extract_plate(const char* extractor, const cv::Mat& image,
                                              const Target& target, const PosePrior& prior,
                                              const ExtractorOptions& options = {}) {
  const FeatureExtractor* found = find_feature_extractor(extractor);
  const PredictedView view =
      predict_features(target, std::array{0, 1, 2, 3}, plate_camera(), prior);
  return extract_features(image, 255, view, {found, found, found}, options);
}

}  // namespace sightline
