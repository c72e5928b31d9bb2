// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Looking for edges across a predicted outline: gradients of a smoothed window, and their peaks
// along a normal.
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace sightline {

/// The gradient of a window smoothed by a Gaussian of 1 px, grey levels a pixel.
class GradientWindow {
 public:
  /// `where` is cut at the image's border; beyond it the image's rim goes on.
  GradientWindow(const cv::Mat& image, const cv::Rect& where);

  /// The derivative along a unit vector, bilinear between pixels; zero outside the window.
  double along(const Eigen::Vector2d& pixel, const Eigen::Vector2d& direction) const {
    const double u = pixel.x() - where_.x;
    const double v = pixel.y() - where_.y;
    if (!(u >= 0 && v >= 0 && u < where_.width - 1 && v < where_.height - 1)) return 0;
    const int column = static_cast<int>(u);
    const int row = static_cast<int>(v);
    return direction.x() * bilinear(du_, column, row, u - column, v - row) +
           direction.y() * bilinear(dv_, column, row, u - column, v - row);
  }

 private:
  static double bilinear(const cv::Mat& image, int column, int row, double u, double v) {
    const float* upper = image.ptr<float>(row) + column;
    const float* lower = image.ptr<float>(row + 1) + column;
    return (1 - v) * ((1 - u) * upper[0] + u * upper[1]) + v * ((1 - u) * lower[0] + u * lower[1]);
  }

  cv::Rect where_;
  cv::Mat du_, dv_;  // CV_32F
};

/// Standard deviation of the smoothed gradient in any direction, for white noise of 1.
inline constexpr double kGradientNoise = 0.19947;  // 1 / sqrt(8 pi)

/// The height of the gradient's peak at a straight edge of contrast 1 blurred by 0.7 px.
inline constexpr double kGradientOfUnitEdge = 0.32;  // 1 / sqrt(2 pi (1 + 0.7^2 + 1/12))

struct EdgePeak {
  double offset_px = 0;  ///< along the normal
  double gradient = 0;   ///< grey levels a pixel, positive where grey rises along the normal
};

/// The strongest few peaks along one normal.
class EdgePeaks {
 public:
  static constexpr int kMost = 4;

  void add(const EdgePeak& peak);
  const EdgePeak* begin() const { return peaks_.data(); }
  const EdgePeak* end() const { return peaks_.data() + size_; }
  int size() const { return size_; }

 private:
  std::array<EdgePeak, kMost> peaks_;
  int size_ = 0;
};

/// The peaks of the gradient along the unit vector `normal` within `half_px` of a pixel, to a small
/// part of a pixel. `polarity` is the sign they must have, 0 for either; `threshold` their least
/// height.
EdgePeaks find_peaks(const GradientWindow& gradients, const Eigen::Vector2d& pixel,
                     const Eigen::Vector2d& normal, double half_px, int polarity, double threshold);

}  // namespace sightline
