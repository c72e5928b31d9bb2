// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/straight_window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

namespace sightline {
namespace {

/// As far as extractors look: along an edge, across it, and what their filters reach beyond.
constexpr int kHalfPx = 104;
/// Where edges are looked at nearly always.
constexpr double kNearPx = 60;
constexpr double kLeastBentPx = 0.02;

/// The derivative of the pixel by the ray (x/z, y/z).
Eigen::Matrix2d pixel_by_ray(const Camera& camera, const Eigen::Vector2d& ray) {
  return lens_jacobian(camera, ray) * Eigen::Vector2d(camera.fx_px, camera.fy_px).asDiagonal();
}

/// The pinhole whose derivative of the pixel by the ray is, up to a turn of the image, this one:
/// the triangular factor of its QR decomposition. It shows the ray at the pixel.
Camera pinhole_of(const Eigen::Matrix2d& by_ray, const Eigen::Vector2d& ray,
                  const Eigen::Vector2d& pixel) {
  Camera camera;
  camera.fx_px = by_ray.col(0).norm();
  camera.skew_px = by_ray.col(0).dot(by_ray.col(1)) / camera.fx_px;
  camera.fy_px = by_ray.determinant() / camera.fx_px;
  camera.cx_px = pixel.x() - camera.fx_px * ray.x() - camera.skew_px * ray.y();
  camera.cy_px = pixel.y() - camera.fy_px * ray.y();
  return camera;
}

/// A line under a change of the image, of which only the derivative matters.
ImageLine under(const Eigen::Matrix2d& change, ImageLine line) {
  const Eigen::Vector2d along = change * line.direction;
  const double length = along.norm();
  // Across the line: what was a pixel, and what was a radian.
  const Eigen::Vector2d scale(change.determinant() / length,
                              change.determinant() / (length * length));
  const double slope_variance = line.covariance(1, 1);
  line.covariance = (scale.asDiagonal() * line.covariance * scale.asDiagonal()).eval();
  if (!std::isfinite(slope_variance)) line.covariance(1, 1) = slope_variance;
  line.direction = along / length;
  line.rms_px *= scale[0];
  return line;
}

}  // namespace

std::optional<StraightWindow> StraightWindow::about(const Eigen::Vector2d& pixel,
                                                    const Camera& camera, const cv::Mat& image) {
  if (is_pinhole(camera.lens)) return std::nullopt;
  const auto ray = normalised_from_pixel(camera, pixel);
  if (!ray) return std::nullopt;
  const Eigen::Matrix2d by_ray = pixel_by_ray(camera, *ray);
  if (!(by_ray.determinant() > 0)) return std::nullopt;
  StraightWindow window;
  window.lens_ = camera;
  // Where the lens does not turn the image either, pixels stay whole ones.
  const Eigen::Vector2d part = pixel.array() - pixel.array().floor();
  window.feature_ = Eigen::Vector2d(kHalfPx, kHalfPx) + part;
  window.pinhole_ = pinhole_of(by_ray, *ray, window.feature_);

  const Eigen::Matrix2d turn = window.in_image_by_pixel(window.feature_);
  double bent_px = 0;
  for (const auto& [x, y] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
    const Eigen::Vector2d off = kNearPx * Eigen::Vector2d(x, y);
    bent_px =
        std::max(bent_px, (window.in_image(window.feature_ + off) - pixel - turn * off).norm());
  }
  if (!(bent_px > kLeastBentPx)) return std::nullopt;

  const cv::Rect seen = window.seen_part({0, 0, 2 * kHalfPx + 1, 2 * kHalfPx + 1}, image.size());
  if (seen.empty()) return std::nullopt;
  window.feature_ -= Eigen::Vector2d(seen.x, seen.y);
  window.pinhole_ = pinhole_of(by_ray, *ray, window.feature_);
  window.pinhole_.width_px = seen.width;
  window.pinhole_.height_px = seen.height;
  cv::Mat u(seen.size(), CV_32F), v(seen.size(), CV_32F);
  for (int y = 0; y < seen.height; ++y) {
    for (int x = 0; x < seen.width; ++x) {
      const Eigen::Vector2d place = window.in_image(Eigen::Vector2d(x, y));
      u.at<float>(y, x) = static_cast<float>(place.x());
      v.at<float>(y, x) = static_cast<float>(place.y());
    }
  }
  cv::remap(image, window.image_, u, v, cv::INTER_LANCZOS4, cv::BORDER_REPLICATE);
  return window;
}

PredictedView StraightWindow::view_of(const PredictedView& view,
                                      const FeaturePrediction& prediction) const {
  // The turn is a rotation, and its transpose goes back.
  const Eigen::Matrix2d turn = in_image_by_pixel(feature_);
  FeaturePrediction here = prediction;
  here.pixel = feature_;
  here.covariance_px2 = turn.transpose() * prediction.covariance_px2 * turn;
  for (Eigen::Vector2d& direction : here.edge_direction) {
    direction = (turn.transpose() * direction).eval();
  }
  return {view.target, pinhole_, view.cam_from_target, {here}};
}

Observation StraightWindow::in_image(Observation found) const {
  const Eigen::Matrix2d change = in_image_by_pixel(found.pixel);
  if (found.status == ObservationStatus::kFound) {
    found.covariance_px2 = (change * found.covariance_px2 * change.transpose()).eval();
  }
  found.pixel = in_image(found.pixel);
  for (ImageLine& line : found.lines) line = in_image(line);
  std::erase_if(found.edge_lines, [this](const EdgeLine& e) { return !is_shown(e.line.point); });
  for (EdgeLine& edge : found.edge_lines) edge.line = in_image(edge.line);
  found.corners = in_image(found.corners);
  found.contour = in_image(found.contour);
  found.laid_outline = in_image(found.laid_outline);
  return found;
}

Eigen::Vector2d StraightWindow::in_image(const Eigen::Vector2d& pixel) const {
  const double y = (pixel.y() - pinhole_.cy_px) / pinhole_.fy_px;
  const double x = (pixel.x() - pinhole_.cx_px - pinhole_.skew_px * y) / pinhole_.fx_px;
  return pixel_from_normalised(lens_, {x, y});
}

std::vector<Eigen::Vector2d> StraightWindow::in_image(
    const std::vector<Eigen::Vector2d>& pixels) const {
  std::vector<Eigen::Vector2d> places;
  places.reserve(pixels.size());
  for (const Eigen::Vector2d& pixel : pixels) places.push_back(in_image(pixel));
  return places;
}

Eigen::Matrix2d StraightWindow::in_image_by_pixel(const Eigen::Vector2d& pixel) const {
  const auto ray = normalised_from_pixel(pinhole_, pixel);
  Eigen::Matrix2d pinhole;
  pinhole << pinhole_.fx_px, pinhole_.skew_px, 0, pinhole_.fy_px;
  return ray ? Eigen::Matrix2d(pixel_by_ray(lens_, *ray) * pinhole.inverse())
             : Eigen::Matrix2d::Identity();
}

ImageLine StraightWindow::in_image(const ImageLine& line) const {
  ImageLine there = under(in_image_by_pixel(line.point), line);
  there.point = in_image(line.point);
  there.edge_pixels = in_image(line.edge_pixels);
  return there;
}

bool StraightWindow::is_shown(const Eigen::Vector2d& pixel) const {
  constexpr double kSamePx = 1e-3;
  // Beyond a fold of the lens a pixel is that of another ray.
  const auto ray = normalised_from_pixel(lens_, in_image(pixel));
  return ray && (pixel_from_normalised(pinhole_, *ray) - pixel).norm() < kSamePx;
}

bool StraightWindow::is_seen(const Eigen::Vector2d& pixel, const cv::Size& image) const {
  const Eigen::Vector2d place = in_image(pixel);
  return place.minCoeff() >= 0 && place.x() <= image.width - 1 && place.y() <= image.height - 1 &&
         is_shown(pixel);
}

cv::Rect StraightWindow::seen_part(cv::Rect window, const cv::Size& image) const {
  constexpr int kStepPx = 4;
  constexpr int kLeastPx = 16;
  const auto unseen = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    const int count = static_cast<int>((to - from).norm()) / kStepPx;
    int unseen_count = 0;
    for (int i = 0; i <= count; ++i) {
      unseen_count += !is_seen(from + (to - from) * i / std::max(count, 1), image);
    }
    return unseen_count;
  };
  while (std::min(window.width, window.height) >= kLeastPx) {
    const double left = window.x, right = window.x + window.width - 1;
    const double top = window.y, bottom = window.y + window.height - 1;
    const std::array sides = {
        unseen({left, top}, {left, bottom}), unseen({right, top}, {right, bottom}),
        unseen({left, top}, {right, top}), unseen({left, bottom}, {right, bottom})};
    const auto worst = std::ranges::max_element(sides);
    if (*worst == 0) return window;
    const auto side = worst - sides.begin();
    if (side == 0) window.x += kStepPx;
    if (side == 2) window.y += kStepPx;
    (side < 2 ? window.width : window.height) -= kStepPx;
  }
  return {};
}

}  // namespace sightline
