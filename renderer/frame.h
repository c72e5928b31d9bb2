// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "scenes/scene.h"

namespace sightline {

/// Where a feature of the target truly is in a frame.
struct FeatureTruth {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  bool is_visible = false;  ///< inside the image and not hidden by the target itself
  bool is_in_image = false;
};

/// What is true of a frame, stated by the frame itself.
struct FrameTruth {
  Camera camera;
  Pose cam_from_target;
  std::vector<FeatureTruth> features;  ///< one a feature of the target
  cv::Rect target_box;                 ///< of the pixels whose centre the target covers
  int target_pixels = 0;
};

/// An image and its truth, pixel by pixel.
struct Frame {
  cv::Mat image;     ///< CV_8U, or CV_16U for more than 8 bits
  cv::Mat depth_m;   ///< CV_64F: z of what the pixel's centre sees; 0 where that is background
  cv::Mat part_ids;  ///< CV_16U: index of the part plus one; 0 is background
  FrameTruth truth;
};

}  // namespace sightline
