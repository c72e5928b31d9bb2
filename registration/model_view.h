// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "renderer/basis.h"

namespace sightline {

/// A light and a background in grey levels: the picture is a * albedo + l . albedo_normal +
/// b (1 - coverage), the five being (a, l_x, l_y, l_z, b), l in the camera's axes.
using LightVector = Eigen::Matrix<double, 5, 1>;

/// Which pixels are compared.
enum class RegistrationRegion {
  kImage,    ///< the target and its surroundings
  kOutline,  ///< a band along its outline alone
};

/// The model's images at a pose as a sensor blurs them: CV_32F, of the size of `box`.
struct ModelView {
  cv::Rect box;
  std::array<cv::Mat, 5> basis;  ///< albedo, three of albedo_normal, 1 - coverage
  cv::Mat is_used;               ///< CV_8U: near the target, or its outline
  /// CV_32FC3: the surface that moves what a pixel shows, in the camera. At a step in depth that is
  /// the nearer one; around the target, that of its nearest pixel. z = 0 where there is none.
  cv::Mat front_m;
  cv::Mat outline;  ///< CV_32F: the slope of the coverage, whose sum is the outline's length, px
};

/// The model's picture in a light, and its derivatives by the pixel (central differences of sixth
/// order).
struct ModelPicture {
  cv::Mat grey, by_x, by_y;
  cv::Mat half_laplacian;  ///< the derivative by the blur's variance
};

/// Blurs basis images by `blur_px`. `region` says what is used; kOutline is for sharp images.
ModelView model_view(const BasisImages& images, double blur_px, RegistrationRegion region);

/// CV_8U, not 0 within 3.5 px of the outline of what is covered.
cv::Mat outline_band(const cv::Mat& coverage);

/// How far around the target pixels are used at that blur.
int reach_px(double blur_px);

/// The margin that basis images need for that blur: reach, filters and differences.
int margin_px(double blur_px);

ModelPicture model_picture(const ModelView& view, const LightVector& light);

}  // namespace sightline
