// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

namespace sightline {

enum class ObservationStatus {
  kFound,
  kHidden,            ///< the target itself hides the feature at the predicted pose
  kOutsideImage,      ///< the predicted feature, or too much of its window, is not on the image
  kWindowTooSmall,    ///< the window is too small to hold an edge
  kSaturated,         ///< the window is white throughout
  kEmptyWindow,       ///< the window is of one grey throughout
  kNoOutline,         ///< the target shows too little of an outline or edge there to look for
  kTooFewEdgePixels,  ///< the window holds no line with enough edge pixels along a predicted edge
  kParallelLines,     ///< the two lines found meet at too small an angle
  kOutsideWindow,     ///< what was found lies outside the window
  kNoCorner,          ///< the window holds no corner
  kMissing,           ///< whoever was asked, outside of this folder, says nothing of it
};

inline constexpr std::array kObservationStatuses = {
    ObservationStatus::kFound,         ObservationStatus::kHidden,
    ObservationStatus::kOutsideImage,  ObservationStatus::kWindowTooSmall,
    ObservationStatus::kSaturated,     ObservationStatus::kEmptyWindow,
    ObservationStatus::kNoOutline,     ObservationStatus::kTooFewEdgePixels,
    ObservationStatus::kParallelLines, ObservationStatus::kOutsideWindow,
    ObservationStatus::kNoCorner,      ObservationStatus::kMissing,
};

/// Words for tables and files: "found", "hidden", "too few edge pixels", ...
std::string_view to_string(ObservationStatus status);

/// A straight line found in an image, with the edge pixels it was fitted to. Of the lines in this
/// folder it alone stands in the image by itself: others are given against a predicted edge.
struct ImageLine {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();       ///< centroid of its edge pixels
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();  ///< unit vector
  std::vector<Eigen::Vector2d> edge_pixels;
  double rms_px = 0;         ///< of the edge pixels about the line
  double contrast_grey = 0;  ///< of its two sides, grey levels of 255; 0 where not measured
  /// Of the line's offset along its normal at `point` (px) and its slope there (rad).
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};

/// A line found along one of a feature's edges, as an observation of that edge: what it says of the
/// pose beyond the feature's pixel, where that was found from it too. Then its slope is known about
/// the pixel alone: the line's covariance is of its offset at `line.point`, where it errs
/// independently of the pixel, and the slope's variance is infinite.
struct EdgeLine {
  int edge = 0;  ///< index into the feature's edges
  ImageLine line;
};

/// What an extractor says of one feature in one image, and the evidence it came from.
struct Observation {
  int feature = 0;  ///< index into the target's features
  ObservationStatus status = ObservationStatus::kNoCorner;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< with status kFound
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();
  /// Of the edges it was found by, the weaker: grey levels of 255; 0 where that was not measured.
  double contrast_grey = 0;
  Eigen::Vector2d predicted_px = Eigen::Vector2d::Zero();
  cv::Rect window;                       ///< where it looked, inside the image
  std::vector<ImageLine> lines;          ///< that a line intersection was found by: two or more
  std::vector<EdgeLine> edge_lines;      ///< what its edges say, whether or not it was found
  std::vector<Eigen::Vector2d> corners;  ///< all the corners a corner extractor chose from
  std::vector<Eigen::Vector2d> contour;  ///< the edge pixels an outline was laid on
  /// That outline where it came to lie: its samples, a pixel apart, in the order of the mesh.
  std::vector<Eigen::Vector2d> laid_outline;
};

/// The standard deviation of a pixel in the direction in which it is known worst, px.
double worst_sd_px(const Eigen::Matrix2d& covariance_px2);

}  // namespace sightline
