// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <opencv2/core/mat.hpp>

#include "pose/camera.h"

namespace sightline {

/// An image as the registration compares it with a model: linear grey levels of 255.
struct GreyImage {
  Camera camera;
  cv::Mat grey;        ///< CV_32F
  cv::Mat is_clipped;  ///< CV_8U, not 0 where the sensor was at white and the light is unknown
};

/// What a sensor gave (CV_8U or CV_16U, `white` its greatest value) as grey levels. Of an image
/// that is encoded as IEC 61966-2-1 (sRGB) says, the encoding is undone.
GreyImage grey_image(const cv::Mat& image, double white, bool is_srgb, const Camera& camera);

/// The image on pixels `factor` times as large, each the mean of those it covers, before the camera
/// that sees it so. What is left over at the right and the bottom is dropped.
GreyImage shrunk(const GreyImage& image, int factor);

/// A CV_32F image blurred as the sensor blurs light: cut at 4 sd, continued over the border.
cv::Mat blurred(const cv::Mat& image, double sigma_px);

/// The standard deviation of the image's noise, grey levels: the median size of what a filter
/// leaves that removes planes (Immerkaer, Computer Vision and Image Understanding 64(2), 1996, who
/// takes the mean, which edges and texture raise). At least 0.3, that of rounding.
double estimated_noise_sd(const cv::Mat& grey);

}  // namespace sightline
