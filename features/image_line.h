// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Straight lines in an image and where two of them meet: what the extractors of line intersections
// share.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "features/observation.h"

namespace sightline {

/// The least-squares line (orthogonal distances) through two or more edge pixels, each of which
/// errs by the scatter about it, or by `least_sd_px` if that is more.
ImageLine fit_line(std::vector<Eigen::Vector2d> edge_pixels, double least_sd_px);

/// Of those pixels the ones within `distance_px` of the line.
std::vector<Eigen::Vector2d> pixels_near(const std::vector<Eigen::Vector2d>& pixels,
                                         const Eigen::Vector2d& point,
                                         const Eigen::Vector2d& normal, double distance_px);

/// The variance of a line's offset along its normal, abreast of a pixel.
double offset_variance_px2(const ImageLine& line, const Eigen::Vector2d& pixel);

/// True where the pixel lies in the window.
bool contains(const cv::Rect& window, const Eigen::Vector2d& pixel);

/// Where lines meet.
struct Meeting {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance_px2;
  double squares = 0;  ///< of the lines' distances from it, each in its own sigmas; 0 for two lines
};

/// The point of least squares of two or more lines, each weighed by its variance abreast of it;
/// none where no two of them are `min_angle_deg` apart.
std::optional<Meeting> meeting_of(std::span<const ImageLine> lines, double min_angle_deg);

/// Sets the observation to where its lines meet, with the covariance that theirs give; or says
/// why they do not: fewer than two, less than `min_angle_deg` apart, or meeting outside the window.
void meet(double min_angle_deg, Observation& observation);

}  // namespace sightline
