// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/straight_window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/LU>
#include <opencv2/core.hpp>

namespace sightline {
namespace {

/// Where edges are looked at nearly always.
constexpr double kNearPx = 60;
constexpr double kLeastBentPx = 0.02;

/// Lanczos' interpolation of four lobes to either side, which leaves white noise nearly white.
/// OpenCV's moves pixels to the next of 32 places between two, and with them the edges by more than
/// fits err.
class Lanczos {
 public:
  Lanczos() {
    for (int phase = 0; phase <= kPhases; ++phase) {
      double sum = 0;
      std::array<double, kTaps> weights;
      for (int tap = 0; tap < kTaps; ++tap) {
        const double x = tap - kBefore - static_cast<double>(phase) / kPhases;
        weights[tap] = sinc(x) * sinc(x / (kTaps / 2));
        sum += weights[tap];
      }
      for (int tap = 0; tap < kTaps; ++tap) {
        weights_[phase][tap] = static_cast<float>(weights[tap] / sum);
      }
    }
  }

  /// Beyond its border the image goes on as it ends.
  uint8_t at(const cv::Mat& image, const Eigen::Vector2d& place) const {
    const Eigen::Array2d first = place.array().floor();
    const int u = static_cast<int>(first.x()) - kBefore;
    const int v = static_cast<int>(first.y()) - kBefore;
    const auto& across = weights_[std::lround((place.x() - first.x()) * kPhases)];
    const auto& down = weights_[std::lround((place.y() - first.y()) * kPhases)];
    const bool is_inside = u >= 0 && v >= 0 && u + kTaps <= image.cols && v + kTaps <= image.rows;
    float sum = 0;
    for (int j = 0; j < kTaps; ++j) {
      const uint8_t* const row = image.ptr<uint8_t>(std::clamp(v + j, 0, image.rows - 1));
      float of_row = 0;
      for (int i = 0; i < kTaps; ++i) {
        of_row += across[i] * row[is_inside ? u + i : std::clamp(u + i, 0, image.cols - 1)];
      }
      sum += down[j] * of_row;
    }
    return cv::saturate_cast<uint8_t>(sum);
  }

 private:
  static constexpr int kTaps = 8;
  static constexpr int kBefore = 3;  // of them before the place
  static constexpr int kPhases = 1024;

  static double sinc(double x) {
    const double angle = std::numbers::pi * x;
    return x == 0 ? 1 : std::sin(angle) / angle;
  }

  std::array<std::array<float, kTaps>, kPhases + 1> weights_;
};

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
                                                    const Camera& camera, const cv::Mat& image,
                                                    int half_px) {
  if (is_pinhole(camera.lens)) return std::nullopt;
  const auto ray = normalised_from_pixel(camera, pixel);
  if (!ray) return std::nullopt;
  const Eigen::Matrix2d by_ray = pixel_by_ray(camera, *ray);
  if (!(by_ray.determinant() > 0)) return std::nullopt;
  StraightWindow window;
  window.lens_ = camera;
  // Where the lens does not turn the image either, pixels stay whole ones.
  const Eigen::Vector2d part = pixel.array() - pixel.array().floor();
  window.feature_ = Eigen::Vector2d(half_px, half_px) + part;
  window.pinhole_ = pinhole_of(by_ray, *ray, window.feature_);

  const Eigen::Matrix2d turn = window.in_image_by_pixel(window.feature_);
  double bent_px = 0;
  for (const auto& [x, y] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
    const Eigen::Vector2d off = kNearPx * Eigen::Vector2d(x, y);
    bent_px =
        std::max(bent_px, (window.in_image(window.feature_ + off) - pixel - turn * off).norm());
  }
  if (!(bent_px > kLeastBentPx)) return std::nullopt;

  const cv::Rect seen = window.seen_part({0, 0, 2 * half_px + 1, 2 * half_px + 1}, image.size());
  if (seen.empty()) return std::nullopt;
  window.image_ = window.interpolated(seen, image);
  window.feature_ -= Eigen::Vector2d(seen.x, seen.y);
  window.pinhole_ = pinhole_of(by_ray, *ray, window.feature_);
  window.pinhole_.width_px = seen.width;
  window.pinhole_.height_px = seen.height;
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
  return {view.target, pinhole_, view.cam_from_target, {here}, view.covariance};
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
  const auto unseen = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    const int count = static_cast<int>((to - from).norm()) / kStepPx;
    int unseen_count = 0;
    for (int i = 0; i <= count; ++i) {
      unseen_count += !is_seen(from + (to - from) * i / std::max(count, 1), image);
    }
    return unseen_count;
  };
  for (;;) {
    const double left = window.x, right = window.x + window.width - 1;
    const double top = window.y, bottom = window.y + window.height - 1;
    struct Side {
      int unseen;
      double room_px;  // from the feature
    };
    const std::array<Side, 4> sides = {{
        {unseen({left, top}, {left, bottom}), feature_.x() - left},
        {unseen({right, top}, {right, bottom}), right - feature_.x()},
        {unseen({left, top}, {right, top}), feature_.y() - top},
        {unseen({left, bottom}, {right, bottom}), bottom - feature_.y()},
    }};
    // The window is turned against the image's border, so that two sides may both be unseen in
    // part: the one that is farther from the feature is moved, where both are alike.
    const auto worst = std::ranges::max_element(sides, {}, [](const Side& side) {
      return side.room_px < kLeastHalfPx + kStepPx ? 0.0 : side.unseen * side.room_px;
    });
    const bool is_seen_all =
        std::ranges::all_of(sides, [](const Side& s) { return s.unseen == 0; });
    if (is_seen_all) return window;
    if (worst->unseen == 0 || worst->room_px < kLeastHalfPx + kStepPx) return {};
    const auto side = worst - sides.begin();
    if (side == 0) window.x += kStepPx;
    if (side == 2) window.y += kStepPx;
    (side < 2 ? window.width : window.height) -= kStepPx;
  }
}

cv::Mat StraightWindow::interpolated(const cv::Rect& window, const cv::Mat& image) const {
  static const Lanczos kLanczos;
  cv::Mat pixels(window.size(), CV_8U);
  for (int v = 0; v < window.height; ++v) {
    uint8_t* const row = pixels.ptr<uint8_t>(v);
    for (int u = 0; u < window.width; ++u) {
      row[u] = kLanczos.at(image, in_image(Eigen::Vector2d(window.x + u, window.y + v)));
    }
  }
  return pixels;
}

}  // namespace sightline
