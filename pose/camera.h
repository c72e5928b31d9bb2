// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Core>

#include "pose/lenses/lens.h"

namespace sightline {

/// A camera with a lens. A ray (x/z, y/z) meets the image at (a, b) = distorted(lens, ray), which
/// is the pixel (fx a + skew b + cx, fy b + cy); the principal point (cx, cy) may lie anywhere,
/// also off the image. Camera frame: x right, y down, z forward, metres. Pixel centres are at
/// integer coordinates: (0, 0) is the centre of the top-left pixel, the image covers [-0.5, width -
/// 0.5] x [-0.5, height - 0.5], and a centred principal point is
/// ((width - 1) / 2, (height - 1) / 2).
struct Camera {
  int width_px = 512;
  int height_px = 512;
  double fx_px = 10000;
  double fy_px = 10000;
  double cx_px = 255.5;
  double cy_px = 255.5;
  double skew_px = 0;  ///< of the pixel's rows: nearly always 0
  Lens lens;
};

/// A distortion-free camera with square pixels and a centred principal point.
Camera centred_camera(int width_px, int height_px, double focal_px);

/// True of a camera whose pixels are (fx x/z + cx, fy y/z + cy): it has neither lens nor skew.
inline bool is_straight(const Camera& camera) {
  return camera.skew_px == 0 && is_pinhole(camera.lens);
}

/// The pixel of a ray (x/z, y/z).
Eigen::Vector2d pixel_from_normalised(const Camera& camera, const Eigen::Vector2d& normalised);

/// The derivative of the pixel by the pixel (fx x/z + cx, fy y/z + cy) that the camera would see
/// without lens and skew, at a point (x/z, y/z) without them.
Eigen::Matrix2d lens_jacobian(const Camera& camera, const Eigen::Vector2d& normalised);

/// The pixel of a point; none for a point at or behind the camera's plane (z <= 0).
/// The pixel may lie outside the image.
std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& x_in_cam);

/// (x/z, y/z) of the ray through a pixel: the inverse of project up to depth.
/// None where the lens cannot be undone (see the models): the ray would lie beyond a fold of the
/// model, or at 90 degrees to the axis or more. None for a pixel that is not finite.
std::optional<Eigen::Vector2d> normalised_from_pixel(const Camera& camera,
                                                     const Eigen::Vector2d& pixel);

/// The unit vector, in the camera frame, towards what a pixel sees. None as above.
std::optional<Eigen::Vector3d> bearing(const Camera& camera, const Eigen::Vector2d& pixel);

/// True when the pixel lies on the image at least `margin_px` inside its border.
bool is_inside(const Camera& camera, const Eigen::Vector2d& pixel, double margin_px = 0);

}  // namespace sightline
