// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a lens bends, made straight about one feature: the image as a pinhole would show it, so that
// what looks for straight edges need not know of lenses. It is the pinhole that shows the feature's
// surroundings as the lens does, only turned: sizes and shapes stay, so that the blur stays as it
// is and the noise white. What is bent, farther away from the feature, moves.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "features/observation.h"
#include "features/prediction.h"
#include "pose/camera.h"

namespace sightline {

class StraightWindow {
 public:
  /// The surroundings of a pixel of an image (CV_8U), as far as `half_px` to each side and no
  /// farther than the image goes. None where straight edges look straight there anyway, to a
  /// fiftieth of a pixel; where the lens cannot be undone; or so near to the image's border that
  /// less than kLeastHalfPx of them would be left on one side.
  static std::optional<StraightWindow> about(const Eigen::Vector2d& pixel, const Camera& camera,
                                             const cv::Mat& image, int half_px);
  static constexpr int kLeastHalfPx = 6;

  const cv::Mat& image() const { return image_; }

  /// The view through the pinhole, of the one feature that is predicted at the pixel.
  PredictedView view_of(const PredictedView& view, const FeaturePrediction& prediction) const;

  /// What was found here, as it is in the image that the lens made. A line is the one that touches
  /// the image of its edge at its point; one whose point the lens does not show is left out.
  Observation in_image(Observation found) const;

 private:
  /// Pixels of the window in the image.
  Eigen::Vector2d in_image(const Eigen::Vector2d& pixel) const;
  std::vector<Eigen::Vector2d> in_image(const std::vector<Eigen::Vector2d>& pixels) const;
  Eigen::Matrix2d in_image_by_pixel(const Eigen::Vector2d& pixel) const;
  ImageLine in_image(const ImageLine& line) const;
  /// Whether the lens shows that pixel of the window, and on an image of this size.
  bool is_shown(const Eigen::Vector2d& pixel) const;
  bool is_seen(const Eigen::Vector2d& pixel, const cv::Size& image) const;
  /// The part of a rectangle of the window that is, with the feature in it; empty where there is
  /// too little.
  cv::Rect seen_part(cv::Rect window, const cv::Size& image) const;
  /// A rectangle of the window, its pixels interpolated from the image.
  cv::Mat interpolated(const cv::Rect& window, const cv::Mat& image) const;

  Camera lens_;
  Camera pinhole_;           ///< its pixels are the window's
  Eigen::Vector2d feature_;  ///< in the window
  cv::Mat image_;
};

}  // namespace sightline
