// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "scenes/scene/scene.h"

namespace sightline {

/// A straight edge of a feature as the image truly has it: its ends' pixels, cut to what lies in
/// front of the camera.
struct EdgeTruth {
  Eigen::Vector2d begin = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
};

/// Where a feature of a target truly is in a frame.
struct FeatureTruth {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  bool is_visible = false;  ///< inside the image and hidden by nothing
  bool is_in_image = false;
  bool is_hidden_by_other = false;  ///< by another body, whatever its own does
  std::vector<EdgeTruth> edges;     ///< of a line intersection: its two
};

/// What is true of one body in a frame.
struct BodyTruth {
  Pose cam_from_target;  ///< at mid-exposure
  bool is_occluder = false;
  std::vector<FeatureTruth> features;  ///< one a feature of its target
  cv::Rect visible_box;                ///< of the pixels whose centre sees the body
  int visible_pixels = 0;
  cv::Rect amodal_box;    ///< as if it were alone, and reaching beyond the image's border
  int amodal_pixels = 0;  ///< alike
  cv::Mat amodal_mask;    ///< CV_8U, 0 or 255, of the image's size

  double visible_fraction() const {
    return amodal_pixels > 0 ? static_cast<double>(visible_pixels) / amodal_pixels : 0;
  }
};

/// What is true of a frame, stated by the frame itself.
struct FrameTruth {
  Camera camera;
  std::vector<BodyTruth> bodies;  ///< the scene's main target first, then its others in order

  const BodyTruth& target() const { return bodies.front(); }
};

/// An image and its truth, pixel by pixel.
struct Frame {
  cv::Mat image;            ///< CV_8U, or CV_16U for more than 8 bits; of a colour picture its grey
  cv::Mat colour;           ///< of a scene in colour, as stored: blue, green, red; else empty
  std::string colour_jpeg;  ///< of a sensor with JPEG the file that holds `colour`; else empty
  cv::Mat depth_m;   ///< CV_64F: z of what the pixel's centre sees; 0 where that is background
  cv::Mat part_ids;  ///< CV_16U: index of the part in its body's mesh plus one; 0 is background
  cv::Mat body_ids;  ///< CV_8U: index of the body plus one; 0 is background
  FrameTruth truth;
};

}  // namespace sightline
