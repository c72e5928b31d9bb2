// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/line_observation.h"

#include <cmath>

namespace sightline {

LineObservation line_through(const Eigen::Vector2d& begin_px, const Eigen::Vector2d& end_px,
                             double sigma_px) {
  LineObservation line;
  line.pixel = (begin_px + end_px) / 2;
  const double length_px = (end_px - begin_px).norm();
  line.direction = (end_px - begin_px) / length_px;
  // The middle is the mean of two offsets, the slope their difference over the length.
  const double variance_px2 = sigma_px * sigma_px;
  line.covariance =
      Eigen::Vector2d(variance_px2 / 2, 2 * variance_px2 / (length_px * length_px)).asDiagonal();
  return line;
}

Eigen::Matrix2d covariance_of_edge_pixels(double length_px, double pixels_per_px, double sigma_px) {
  const double offset_px2 = sigma_px * sigma_px / (length_px * pixels_per_px);
  return Eigen::Vector2d(offset_px2, 12 * offset_px2 / (length_px * length_px)).asDiagonal();
}

bool is_usable(const LineObservation& line) {
  constexpr double kLargest = 1e60;  // coordinates beyond it, or their products, are no numbers
  const Eigen::Matrix2d& c = line.covariance;
  const auto is_manageable = [kLargest](const auto& v) {
    return (v.array().abs() < kLargest).all();
  };
  const bool is_finite = is_manageable(line.begin_in_target) && is_manageable(line.end_in_target) &&
                         is_manageable(line.pixel) && is_manageable(line.direction);
  const bool has_length = (line.end_in_target - line.begin_in_target).squaredNorm() > 0 &&
                          line.direction.squaredNorm() > 0;
  const bool is_slope_known = std::isfinite(c(1, 1));
  const bool is_noise = c(0, 0) > 0 && std::isfinite(c(0, 0)) && c(1, 1) > 0 && c(0, 1) == c(1, 0);
  if (!is_finite || !has_length || !is_noise) return false;
  return is_slope_known ? c(0, 0) * c(1, 1) > c(0, 1) * c(0, 1) : c(0, 1) == 0;
}

}  // namespace sightline
