// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "features/edge_search.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

namespace sightline {
namespace {

constexpr int kRadiusPx = 4;  // of the smoothing kernel: 6e-5 of it is left out
using Kernel = std::array<float, 2 * kRadiusPx + 1>;

Kernel gaussian() {
  Kernel kernel;
  float sum = 0;
  for (int i = -kRadiusPx; i <= kRadiusPx; ++i) {
    kernel[i + kRadiusPx] = std::exp(-0.5F * static_cast<float>(i * i));
    sum += kernel[i + kRadiusPx];
  }
  for (float& value : kernel) value /= sum;
  return kernel;
}

// Its derivative, as a correlation; of a ramp of slope 1 it gives 1.
Kernel gaussian_derivative() {
  Kernel kernel = gaussian();
  float moment = 0;
  for (int i = -kRadiusPx; i <= kRadiusPx; ++i) {
    kernel[i + kRadiusPx] *= static_cast<float>(i);
    moment += static_cast<float>(i) * kernel[i + kRadiusPx];
  }
  for (float& value : kernel) value /= moment;
  return kernel;
}

}  // namespace

GradientWindow::GradientWindow(const cv::Mat& image, const cv::Rect& where)
    : where_(where & cv::Rect({0, 0}, image.size())) {
  if (where_.empty()) return;
  static const Kernel kSmooth = gaussian();
  static const Kernel kDerive = gaussian_derivative();
  const cv::Mat smooth(1, static_cast<int>(kSmooth.size()), CV_32F,
                       const_cast<float*>(kSmooth.data()));
  const cv::Mat derive(1, static_cast<int>(kDerive.size()), CV_32F,
                       const_cast<float*>(kDerive.data()));
  cv::sepFilter2D(image(where_), du_, CV_32F, derive, smooth, {-1, -1}, 0, cv::BORDER_REPLICATE);
  cv::sepFilter2D(image(where_), dv_, CV_32F, smooth, derive, {-1, -1}, 0, cv::BORDER_REPLICATE);
}

void EdgePeaks::add(const EdgePeak& peak) {
  if (size_ < kMost) {
    peaks_[size_++] = peak;
    return;
  }
  EdgePeak* weakest =
      std::min_element(peaks_.begin(), peaks_.end(), [](const EdgePeak& a, const EdgePeak& b) {
        return std::abs(a.gradient) < std::abs(b.gradient);
      });
  if (std::abs(peak.gradient) > std::abs(weakest->gradient)) *weakest = peak;
}

EdgePeaks find_peaks(const GradientWindow& gradients, const Eigen::Vector2d& pixel,
                     const Eigen::Vector2d& normal, double half_px, int polarity,
                     double threshold) {
  EdgePeaks peaks;
  const int last = static_cast<int>(std::ceil(half_px)) + 1;
  // A peak of either sign is one of the magnitude.
  const auto value_at = [&](int k) {
    const double gradient = gradients.along(pixel + k * normal, normal);
    return polarity == 0 ? gradient : polarity * gradient;
  };
  double before = value_at(-last);
  double here = value_at(-last + 1);
  for (int k = -last + 1; k < last; ++k) {
    const double after = value_at(k + 1);
    const double sign = polarity == 0 && here < 0 ? -1 : 1;
    const double b = sign * before;
    const double h = sign * here;
    const double a = sign * after;
    before = here;
    here = after;
    if (!(h >= threshold && h > b && h >= a)) continue;
    const double shift = 0.5 * (a - b) / (2 * h - a - b);
    const double offset_px = k + shift;
    if (std::abs(offset_px) > half_px) continue;
    const double height = h + 0.25 * (a - b) * shift;
    peaks.add({offset_px, sign * (polarity == 0 ? 1 : polarity) * height});
  }
  return peaks;
}

}  // namespace sightline
