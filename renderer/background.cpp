// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/background.h"

namespace sightline {

cv::Mat background_image(const Background& background, cv::Size size) {
  return cv::Mat(size, CV_32F, cv::Scalar(background.level));
}

}  // namespace sightline
