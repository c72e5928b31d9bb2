// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "pose/camera.h"

namespace sightline {
namespace {

// How fast a mesh's picture turns from one pixel to the next: of its coverage, and of its surface's
// normal where that is seen.
struct Turning {
  explicit Turning(const BasisImages& images) : strength(images.coverage.size(), CV_32F) {
    std::array<cv::Mat, 4> fields = {images.coverage};
    for (size_t k = 0; k < 3; ++k) {
      cv::divide(images.albedo_normal[k], cv::max(images.albedo, 1e-3), fields[k + 1]);
      fields[k + 1] = fields[k + 1].mul(images.coverage);
    }
    cv::Mat xx = cv::Mat::zeros(strength.size(), CV_32F), xy = xx.clone(), yy = xx.clone();
    for (const cv::Mat& field : fields) {
      cv::Mat by_x, by_y;
      cv::Sobel(field, by_x, CV_32F, 1, 0, 3, 1 / 8.0);
      cv::Sobel(field, by_y, CV_32F, 0, 1, 3, 1 / 8.0);
      if (outline.empty()) cv::magnitude(by_x, by_y, outline);  // the coverage comes first
      xx += by_x.mul(by_x);
      xy += by_x.mul(by_y);
      yy += by_y.mul(by_y);
    }
    angle_rad.create(strength.size(), CV_32F);
    for (int y = 0; y < strength.rows; ++y) {
      for (int x = 0; x < strength.cols; ++x) {
        const float a = xx.at<float>(y, x), b = xy.at<float>(y, x), c = yy.at<float>(y, x);
        // Of the structure tensor: the greater eigenvalue, and its direction.
        const float root = std::hypot((a - c) / 2, b);
        strength.at<float>(y, x) = std::sqrt((a + c) / 2 + root);
        angle_rad.at<float>(y, x) = std::atan2(2 * b, a - c) / 2;
      }
    }
  }

  Eigen::Vector2d normal(int x, int y) const {
    const double angle = angle_rad.at<float>(y, x);
    return {std::cos(angle), std::sin(angle)};
  }

  // Where within the pixel it turns fastest, along the normal; none where it turns faster a pixel
  // to either side.
  std::optional<Eigen::Vector2d> ridge(int x, int y) const {
    const Eigen::Vector2d n = normal(x, y);
    const int dx = static_cast<int>(std::lround(n.x())), dy = static_cast<int>(std::lround(n.y()));
    const double own = strength.at<float>(y, x);
    const double after = strength.at<float>(y + dy, x + dx);
    const double before = strength.at<float>(y - dy, x - dx);
    if (own < after || own <= before) return std::nullopt;
    const double at = top_of_parabola(before, own, after) * std::hypot(dx, dy);
    return Eigen::Vector2d(x, y) + at * n;
  }

  cv::Mat outline;    // CV_32F, of the coverage alone
  cv::Mat strength;   // CV_32F, of all
  cv::Mat angle_rad;  // CV_32F, of the direction across
};

// The depth of an edge's point: of the nearest seen by the pixel itself or, where that sees
// nothing, by those around it. 0 where they do not either.
float depth_near_m(const cv::Mat& front_m, int x, int y) {
  float found_m = front_m.at<cv::Vec3f>(y, x)[2];
  if (found_m > 0) return found_m;
  for (int v = y - 1; v <= y + 1; ++v) {
    for (int u = x - 1; u <= x + 1; ++u) {
      const float other_m = front_m.at<cv::Vec3f>(v, u)[2];
      if (other_m > 0 && (found_m == 0 || other_m < found_m)) found_m = other_m;
    }
  }
  return found_m;
}

// Bilinear; none outside.
std::optional<double> value_at(const cv::Mat& image, const Eigen::Vector2d& pixel) {
  const double fx = std::floor(pixel.x()), fy = std::floor(pixel.y());
  if (!(fx >= 0 && fy >= 0 && fx + 1 < image.cols && fy + 1 < image.rows)) return std::nullopt;
  const int x = static_cast<int>(fx), y = static_cast<int>(fy);
  const double u = pixel.x() - fx, v = pixel.y() - fy;
  const float* const a = image.ptr<float>(y) + x;
  const float* const b = image.ptr<float>(y + 1) + x;
  return (1 - v) * ((1 - u) * a[0] + u * a[1]) + v * ((1 - u) * b[0] + u * b[1]);
}

}  // namespace

std::vector<MeshEdgePoint> edge_points(const BasisImages& images, const Camera& camera,
                                       const Pose& cam_from_target) {
  // The coverage falls by half a unit a pixel along an outline; a surface that turns by 20 degrees
  // from one pixel to the next is a crease.
  constexpr float kLeastTurning = 0.17F;
  constexpr float kLeastOutline = 0.2F;
  const Turning turning(images);
  const Pose target_from_cam = inverse(cam_from_target);
  std::vector<MeshEdgePoint> points;
  for (int y = 1; y + 1 < images.box.height; ++y) {
    for (int x = 1; x + 1 < images.box.width; ++x) {
      if (turning.strength.at<float>(y, x) < kLeastTurning) continue;
      const auto ridge = turning.ridge(x, y);
      const float depth_m = depth_near_m(images.front_m, x, y);
      if (!ridge || depth_m == 0) continue;
      const Eigen::Vector2d pixel = *ridge + Eigen::Vector2d(images.box.x, images.box.y);
      const auto ray = normalised_from_pixel(camera, pixel);
      if (!ray) continue;
      points.push_back({target_from_cam * (depth_m * ray->homogeneous()), turning.normal(x, y),
                        turning.outline.at<float>(y, x) > kLeastOutline});
    }
  }
  return points;
}

EdgeImage::EdgeImage(const GreyImage& image, double blur_px) {
  const cv::Mat smooth = blurred(image.grey, blur_px);
  cv::Sobel(smooth, by_x, CV_32F, 1, 0, 3, 1 / 8.0);
  cv::Sobel(smooth, by_y, CV_32F, 0, 1, 3, 1 / 8.0);
}

std::optional<double> slope_along(const EdgeImage& image, const Eigen::Vector2d& normal,
                                  const Eigen::Vector2d& pixel) {
  const auto x = value_at(image.by_x, pixel), y = value_at(image.by_y, pixel);
  if (!x || !y) return std::nullopt;
  return std::abs(normal.x() * *x + normal.y() * *y);
}

double top_of_parabola(double before, double middle, double after) {
  const double curvature = before - 2 * middle + after;
  return curvature < 0 ? 0.5 * (before - after) / curvature : 0;
}

double worth_of_slope(double slope) {
  constexpr double kHalfGrey = 6;
  return slope / (slope + kHalfGrey);
}

double edge_support(const EdgeImage& image, const Camera& camera,
                    const std::vector<MeshEdgePoint>& points, const Pose& cam_from_target) {
  double sum = 0;
  for (const MeshEdgePoint& point : points) {
    const auto pixel = project(camera, cam_from_target * point.in_target_m);
    const auto slope = pixel ? slope_along(image, point.normal, *pixel) : std::nullopt;
    if (slope) sum += worth_of_slope(*slope);
  }
  return points.empty() ? 0 : sum / static_cast<double>(points.size());
}

double outline_contrast(const EdgeImage& image, const Camera& camera,
                        const std::vector<MeshEdgePoint>& points, const Pose& cam_from_target) {
  constexpr int kReachPx = 6;
  std::array<double, 2 * kReachPx + 1> sums{};
  for (const MeshEdgePoint& point : points) {
    const auto pixel = project(camera, cam_from_target * point.in_target_m);
    if (!point.is_outline || !pixel) continue;
    for (int offset = -kReachPx; offset <= kReachPx; ++offset) {
      const auto slope = slope_along(image, point.normal, *pixel + offset * point.normal);
      sums[static_cast<size_t>(offset + kReachPx)] += slope.value_or(0);
    }
  }
  const double at_outline = std::max({sums[kReachPx - 1], sums[kReachPx], sums[kReachPx + 1]});
  std::nth_element(sums.begin(), sums.begin() + kReachPx, sums.end());
  return sums[kReachPx] > 0 ? at_outline / sums[kReachPx] : 0;
}

}  // namespace sightline
