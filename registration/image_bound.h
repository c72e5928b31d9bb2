// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "pose/pose.h"
#include "renderer/renderer.h"
#include "scenes/scene/scene.h"

namespace sightline {

/// How the derivatives of an image are taken: central differences of noise-free renderings.
struct ImageBoundOptions {
  int samples_per_pixel = 64;
  double step_px = 0.1;  ///< by which the target's rim moves to either side
};

/// The Cramér-Rao bounds of the pose from one image: no unbiased estimator that sees the image
/// alone has a smaller covariance of (w, dt), cam_from_target = (Exp(w) R, t + dt). None where the
/// image does not determine a pose.
struct ImageBounds {
  std::optional<Matrix6d> known_light;  ///< and all else but the pose is known
  /// Glow, light, background and with them gain and offset of the image are unknown.
  std::optional<Matrix6d> unknown_light;
  /// Only the band of 3.5 px along the outline is seen, and in every square of 12 px of it the
  /// greys on both sides are unknown.
  std::optional<Matrix6d> outline;
};

/// The bounds for a scene and its own sensor: point spread, read and photon noise, rounding (as
/// noise of 1/12 of a step squared), encoding; pixels at white or black tell nothing. Throws
/// InputError for a scene that cannot be imaged, or that cannot at a pose beside its own.
ImageBounds image_bounds(const Scene& scene, Renderer& renderer,
                         const ImageBoundOptions& options = {});

/// The information of an image whose derivatives by some unknowns are given (CV_32F each): the sum
/// over pixels of j j' / variance, j the derivatives; where the variance (CV_32F) is zero the pixel
/// tells nothing.
Eigen::MatrixXd image_information(std::span<const cv::Mat> derivatives, const cv::Mat& variance);

/// The information of the first `kept` unknowns, the others being unknown too.
Eigen::MatrixXd marginal_information(const Eigen::MatrixXd& information, int kept);

}  // namespace sightline
