// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "features/extractor.h"

namespace sightline {

/// Canny's edge pixels in a window and the lines of their Hough transform with votes enough.
struct HoughTransform {
  struct Line {
    double distance_px;  ///< of the origin, along the normal
    Eigen::Vector2d normal;
  };
  std::vector<Eigen::Vector2d> edge_pixels;
  std::vector<Line> lines;  ///< most votes first
};

HoughTransform hough_transform(const cv::Mat& image, const cv::Rect& window,
                               const LineOptions& options);

/// Of the lines nearly parallel to a direction at most so many, most votes first and each other
/// than those before it, fitted by least squares to the edge pixels that agree. Where the search is
/// gated, lines that pass outside it do not count.
std::vector<ImageLine> lines_along(const Eigen::Vector2d& direction, const HoughTransform& hough,
                                   const ExtractionInput& input, const LineOptions& options,
                                   size_t most);

}  // namespace sightline
