// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <opencv2/core/mat.hpp>

#include "scenes/scene/background.h"

namespace sightline {

/// The light that a background puts on the focal plane: CV_32F, 1 is white, never negative, one
/// value a pixel. The same for the same background and size, whatever lies in front of it.
///
/// kUniform: `level`. kSky: linear along `angle_deg`; the corner pixels that lie farthest in and
/// against that direction have level +- contrast / 2. kClouds: octaves of cubic B-spline noise,
/// from structures of `cloud_px` down to those of a pixel or two, each 0.6 times as strong as the
/// one of twice its size (radiance of real clouds: between 0.5 and 0.8), shifted and scaled so that
/// mean and standard deviation over the image are `level` and contrast / 2; then what is negative
/// is cut to zero. kStars: a Poisson process on `level`; the number of stars brighter than F goes
/// as 1 / F, up to `star_level` and down to a hundredth of it; the light of each is shared by the
/// four pixel centres about it. kImage: `picture` scaled to cover the image, its middle in the
/// middle. kEnvironment: as kUniform; environment_image() has the panorama.
cv::Mat background_image(const Background& background, cv::Size size);

/// The same in colour: CV_32FC3, blue, green and red. A picture has its colours, all else is grey.
cv::Mat colour_background_image(const Background& background, cv::Size size);

}  // namespace sightline
