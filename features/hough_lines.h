// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "features/extractor.h"

namespace sightline {

/// The standard deviation of an edge pixel across its edge: 1/sqrt(12), as Canny gives whole
/// pixels.
inline constexpr double kEdgeQuantisationPx = 0.29;

/// A line that edge pixels vote for: normal . pixel = distance.
struct HoughLine {
  double distance_px;  ///< of the origin, along the normal
  Eigen::Vector2d normal;
};

/// Canny's edge pixels in a window and the lines of their Hough transform with votes enough.
struct HoughTransform {
  std::vector<Eigen::Vector2d> edge_pixels;
  std::vector<HoughLine> lines;  ///< most votes first
};

/// The lines of a window of an image (CV_8U) with at least `options.min_votes` votes.
HoughTransform hough_transform(const cv::Mat& image, const cv::Rect& window,
                               const LineOptions& options);

/// Of the Hough lines nearly parallel to a direction at most so many, most votes first, each fitted
/// by least squares to the edge pixels near it. A line that shares most of its edge pixels with one
/// before it is left out. Where the search is gated, lines that pass outside it do not count.
std::vector<ImageLine> lines_along(const Eigen::Vector2d& direction, const HoughTransform& hough,
                                   const ExtractionInput& input, const LineOptions& options,
                                   size_t most);

}  // namespace sightline
