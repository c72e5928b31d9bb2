// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The corner of Harris and Stephens (1988) nearest the window's centre, moved to where the
// gradients around it are orthogonal to their arms (Foerstner and Guelch 1987, as OpenCV's
// cornerSubPix).
#include <algorithm>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "features/extractors/extractors.h"

namespace sightline {
namespace {

constexpr int kHarrisAperture = 3;
constexpr double kHarrisK = 0.04;
constexpr int kRefineHalfPx = 5;
constexpr double kMaxMovePx = 4;
// Harris' response, as OpenCV scales it, at a right-angled corner of contrast 1 blurred by 0.7 px
// under a block of 5 px: it grows with the fourth power of the contrast. Measured.
constexpr double kHarrisOfUnitCorner = 0.02;
// Of a refined corner, in each coordinate: an upper estimate. The test OnAPlate holds it to no less
// than the error on a plate with noise of 3 grey levels.
constexpr double kSdPx = 0.4;

}  // namespace

Observation extract_harris_subpixel(const ExtractionInput& input) {
  const CornerOptions& options = input.options.corner;
  const int border_px = std::max(options.block_px, kRefineHalfPx) + 2;
  const cv::Rect& window = input.window;
  const cv::Rect wide = cv::Rect(window.x - border_px, window.y - border_px,
                                 window.width + 2 * border_px, window.height + 2 * border_px) &
                        cv::Rect({0, 0}, input.image.size());
  cv::Mat grey;
  input.image(wide).convertTo(grey, CV_32F);
  cv::Mat mask = cv::Mat::zeros(wide.size(), CV_8U);
  mask(cv::Rect(window.tl() - wide.tl(), window.size())) = 255;

  Observation observation = nothing_found(input);
  cv::Mat response;
  cv::cornerHarris(grey, response, options.block_px, kHarrisAperture, kHarrisK);
  double best = 0;
  cv::minMaxLoc(response, nullptr, &best, nullptr, nullptr, mask);
  const double contrast2 = options.min_contrast_grey * options.min_contrast_grey;
  const double least = kHarrisOfUnitCorner * contrast2 * contrast2;
  if (!(best >= least) || !(best > 0)) return observation;
  std::vector<cv::Point2f> found;
  cv::goodFeaturesToTrack(grey, found, options.max_corners,
                          std::max(options.quality * options.quality, least / best),
                          options.min_distance_px, mask, options.block_px, kHarrisAperture,
                          /*useHarrisDetector=*/true, kHarrisK);
  if (found.empty()) return observation;
  const std::vector<cv::Point2f> whole = found;
  cv::cornerSubPix(grey, found, {kRefineHalfPx, kRefineHalfPx}, {-1, -1},
                   {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 30, 1e-3});
  const Eigen::Vector2d origin(wide.x, wide.y);
  double nearest_px = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < found.size(); ++i) {
    const cv::Point2f moved = found[i] - whole[i];
    const bool is_refined = std::hypot(moved.x, moved.y) <= kMaxMovePx;
    const cv::Point2f& point = is_refined ? found[i] : whole[i];
    const Eigen::Vector2d pixel = origin + Eigen::Vector2d(point.x, point.y);
    observation.corners.push_back(pixel);
    const double distance_px = (pixel - input.prediction.pixel).norm();
    if (distance_px >= nearest_px) continue;
    nearest_px = distance_px;
    observation.pixel = pixel;
  }
  observation.status = ObservationStatus::kFound;
  observation.covariance_px2 = kSdPx * kSdPx * Eigen::Matrix2d::Identity();
  return observation;
}

}  // namespace sightline
