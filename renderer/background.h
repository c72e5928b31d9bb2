// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <opencv2/core/mat.hpp>

#include "scenes/scene.h"

namespace sightline {

/// What lies behind all bodies: linear light, CV_32F, 1 is white.
cv::Mat background_image(const Background& background, cv::Size size);

}  // namespace sightline
