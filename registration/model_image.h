// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include <opencv2/core/mat.hpp>

#include "registration/registration.h"

namespace sightline {

/// The mesh as it would look at a pose, beside the image: what a registration compares.
struct ModelImage {
  cv::Rect box;        ///< of the image; what follows is of its size
  cv::Mat model_grey;  ///< CV_32F, linear grey levels of 255
  /// CV_32F: image less model over the noise's standard deviation; NaN where they are not compared,
  /// far from the target or where the sensor is at white.
  cv::Mat residual_sds;
};

/// Draws the mesh at a pose in the one light, background and blur that suit the image best. Squares
/// have no light of their own here, so that shadows, paint and bodies in front are seen as what the
/// model does not explain. None where the mesh is not wholly in front of the camera or not in the
/// image.
std::optional<ModelImage> model_image(const RegistrationTask& task,
                                      const RegistrationOptions& options,
                                      const Pose& cam_from_target);

}  // namespace sightline
