// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The nose of the ORPE paper (section 4): of the corners found in the window, the one nearest its
// centre, which is the prediction. The paper names no detector; this is Shi and Tomasi's (CVPR
// 1994): local maxima of the smaller eigenvalue of the structure tensor. A floor under that
// eigenvalue keeps an empty window from offering the noise's own maxima as corners.
#include <algorithm>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "features/extractors/extractors.h"

namespace sightline {
namespace {

constexpr int kSobelAperture = 3;
// The smaller eigenvalue, as OpenCV scales it, at a right-angled corner of contrast 1 blurred by
// 0.7 px under a block of 5 px. Measured; it grows with the square of the contrast. The test
// ShiTomasiNearest.TheContrastFloorMeansWhatItSays holds it between 0.6 and 1.5 of a contrast.
constexpr double kResponseOfUnitCorner = 0.14;

// The least quality, as a fraction of the best corner under the mask, that also meets the floor;
// above 1 when no corner does.
double least_quality(const cv::Mat& image, const cv::Mat& mask, const CornerOptions& options) {
  cv::Mat smaller_eigenvalue;
  cv::cornerMinEigenVal(image, smaller_eigenvalue, options.block_px, kSobelAperture);
  double best = 0;
  cv::minMaxLoc(smaller_eigenvalue, nullptr, &best, nullptr, nullptr, mask);
  if (best <= 0) return std::numeric_limits<double>::infinity();
  const double contrast = options.min_contrast_grey;
  return std::max(options.quality, kResponseOfUnitCorner * contrast * contrast / best);
}

}  // namespace

Observation extract_shi_tomasi_nearest(const ExtractionInput& input) {
  const cv::Mat& image = input.image;
  const CornerOptions& corner = input.options.corner;
  // With a border of the image around the window: mirrored at its rim, an edge would make a corner.
  const int border_px = corner.block_px / 2 + kSobelAperture / 2 + 1;
  const cv::Rect& window = input.window;
  const cv::Rect wide = cv::Rect(window.x - border_px, window.y - border_px,
                                 window.width + 2 * border_px, window.height + 2 * border_px) &
                        cv::Rect({0, 0}, image.size());
  cv::Mat grey;  // as float, where OpenCV's eigenvalues are in grey levels squared
  image(wide).convertTo(grey, CV_32F);
  cv::Mat mask = cv::Mat::zeros(wide.size(), CV_8U);
  mask(cv::Rect(window.tl() - wide.tl(), window.size())) = 255;

  Observation observation = nothing_found(input);
  const double quality = least_quality(grey, mask, corner);
  if (quality > 1) return observation;
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(grey, found, corner.max_corners, quality, corner.min_distance_px, mask,
                          corner.block_px, kSobelAperture);
  const Eigen::Vector2d origin(wide.x, wide.y);
  double nearest_px = std::numeric_limits<double>::infinity();
  for (const cv::Point2f& point : found) {
    const Eigen::Vector2d pixel = origin + Eigen::Vector2d(point.x, point.y);
    observation.corners.push_back(pixel);
    const double distance_px = (pixel - input.prediction.pixel).norm();
    if (distance_px >= nearest_px) continue;
    nearest_px = distance_px;
    observation.pixel = pixel;
  }
  if (found.empty()) return observation;
  observation.status = ObservationStatus::kFound;
  // A structure tensor places a corner no better than its block: uniform over it.
  const double variance_px2 = corner.block_px * corner.block_px / 12.0;
  observation.covariance_px2 = variance_px2 * Eigen::Matrix2d::Identity();
  return observation;
}

}  // namespace sightline
