// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The nose of the ORPE paper (section 4): of the corners found in the window, the one nearest its
// centre. The paper names no detector; this is Shi and Tomasi's (CVPR 1994): local maxima of the
// smaller eigenvalue of the structure tensor. A floor under that eigenvalue keeps an empty window
// from offering the noise's own maxima as corners.
#include <algorithm>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "features/extractors/extractors.h"

namespace sightline {
namespace {

constexpr int kSobelAperture = 3;
// The smaller eigenvalue, as OpenCV scales it, at a right-angled corner of contrast 1 blurred by
// 0.7 px under a block of 5 px. Measured; the test of this extractor holds it to its meaning.
constexpr double kResponseOfUnitCorner = 0.14;

// The least quality, as a fraction of the window's best corner, that also meets the floor; above 1
// when no corner does.
double least_quality(const cv::Mat& window, const CornerOptions& options) {
  cv::Mat smaller_eigenvalue;
  cv::cornerMinEigenVal(window, smaller_eigenvalue, options.block_px, kSobelAperture);
  double best = 0;
  cv::minMaxLoc(smaller_eigenvalue, nullptr, &best);
  if (best <= 0) return std::numeric_limits<double>::infinity();
  const double contrast = options.min_contrast_grey;
  return std::max(options.quality, kResponseOfUnitCorner * contrast * contrast / best);
}

}  // namespace

void extract_shi_tomasi_nearest(const cv::Mat& image, const FeaturePrediction& prediction,
                                const ExtractorOptions& options, Observation& observation) {
  const CornerOptions& corner = options.corner;
  cv::Mat window;  // as float, where OpenCV's eigenvalues are in grey levels squared
  image(observation.window).convertTo(window, CV_32F);
  const double quality = least_quality(window, corner);
  observation.status = ObservationStatus::kNoCorner;
  if (quality > 1) return;
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(window, found, corner.max_corners, quality, corner.min_distance_px,
                          cv::noArray(), corner.block_px, kSobelAperture);
  const Eigen::Vector2d origin(observation.window.x, observation.window.y);
  double nearest_px = std::numeric_limits<double>::infinity();
  for (const cv::Point2f& point : found) {
    const Eigen::Vector2d pixel = origin + Eigen::Vector2d(point.x, point.y);
    observation.corners.push_back(pixel);
    const double distance_px = (pixel - prediction.pixel).norm();
    if (distance_px >= nearest_px) continue;
    nearest_px = distance_px;
    observation.pixel = pixel;
  }
  if (found.empty()) return;
  observation.status = ObservationStatus::kFound;
  // A structure tensor places a corner no better than its block: uniform over it.
  const double variance_px2 = corner.block_px * corner.block_px / 12.0;
  observation.covariance_px2 = variance_px2 * Eigen::Matrix2d::Identity();
}

}  // namespace sightline
