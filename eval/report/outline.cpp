// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/outline.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

#include "renderer/truth.h"

namespace sightline {
namespace {

// Poses of different solvers differ by less than a pixel, which whole pixels could not show.
constexpr int kSubdivision = 4;
constexpr int kMaxSidePx = 4096;  // of the picture that is traced
// Of the polygon from the traced border, in subdivided pixels: halves the vertices, moves none by
// as much as the eye sees.
constexpr double kSimplificationPx = 0.6;
constexpr double kMinAreaPx2 = 4;  // specks of a few subdivided pixels are no outline

int subdivision(const Camera& camera) {
  const int side = std::max(camera.width_px, camera.height_px);
  return std::clamp(kMaxSidePx / std::max(side, 1), 1, kSubdivision);
}

// Centres of parts lie at (c + 1/2) / factor - 1/2 of the coarse pixels.
Eigen::Vector2d coarse_pixel(const cv::Point& part, int factor) {
  return Eigen::Vector2d((part.x + 0.5) / factor - 0.5, (part.y + 0.5) / factor - 0.5);
}

// The borders of what is covered, which has `factor` parts a pixel each way.
Outline traced(const cv::Mat& covered, int factor) {
  std::vector<std::vector<cv::Point>> borders;
  cv::findContours(covered, borders, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  Outline outline;
  for (const std::vector<cv::Point>& border : borders) {
    if (cv::contourArea(border) < kMinAreaPx2) continue;
    std::vector<cv::Point> simple;
    cv::approxPolyDP(border, simple, kSimplificationPx, /*closed=*/true);
    std::vector<Eigen::Vector2d>& polygon = outline.emplace_back();
    for (const cv::Point& part : simple) polygon.push_back(coarse_pixel(part, factor));
  }
  return outline;
}

}  // namespace

Camera finer(const Camera& camera, int factor) {
  Camera fine = camera;
  fine.width_px *= factor;
  fine.height_px *= factor;
  fine.fx_px *= factor;
  fine.fy_px *= factor;
  fine.skew_px *= factor;
  fine.cx_px = (camera.cx_px + 0.5) * factor - 0.5;
  fine.cy_px = (camera.cy_px + 0.5) * factor - 0.5;
  return fine;
}

Outline target_outline(Renderer& renderer, const Scene& scene, const Pose& cam_from_target) {
  const int factor = subdivision(scene.camera);
  Scene posed = scene;
  posed.cam_from_target = cam_from_target;
  posed.camera = finer(scene.camera, factor);
  if (!why_not_imageable(posed).empty()) return {};

  return traced(renderer.render_part_ids(posed) != 0, factor);
}

Outline mesh_outline(const Mesh& mesh, const Camera& camera, const Pose& cam_from_mesh) {
  const int factor = subdivision(camera);
  return traced(depth_alone(mesh, finer(camera, factor), cam_from_mesh) > 0, factor);
}

}  // namespace sightline
