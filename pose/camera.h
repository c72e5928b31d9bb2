// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Core>

namespace sightline {

/// Lens distortion after Brown (1966) and Conrady (1919), with the coefficients and signs of
/// OpenCV: x_d = x (1 + k1 r2 + k2 r4 + k3 r6) + 2 p1 x y + p2 (r2 + 2 x2), and alike for y.
struct BrownConrady {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  bool is_zero() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0; }
};

/// A pinhole camera with lens distortion. Camera frame: x right, y down, z forward, metres.
/// Pixel centres are at integer coordinates: (0, 0) is the centre of the top-left pixel, the image
/// covers [-0.5, width - 0.5] x [-0.5, height - 0.5], and a centred principal point is
/// ((width - 1) / 2, (height - 1) / 2).
struct Camera {
  int width_px = 512;
  int height_px = 512;
  double fx_px = 10000;
  double fy_px = 10000;
  double cx_px = 255.5;
  double cy_px = 255.5;
  BrownConrady distortion;
};

/// A distortion-free camera with square pixels and a centred principal point.
Camera centred_camera(int width_px, int height_px, double focal_px);

/// Where the lens puts the ray (x/z, y/z), still in normalised coordinates.
Eigen::Vector2d distorted(const BrownConrady& lens, const Eigen::Vector2d& normalised);

/// The derivative of `distorted`. Its determinant is positive wherever the lens can be undone.
Eigen::Matrix2d distortion_jacobian(const BrownConrady& lens, const Eigen::Vector2d& normalised);

/// The derivative of the pixel by the pixel that the camera would see without its lens, at a point
/// (x/z, y/z) without it.
Eigen::Matrix2d lens_jacobian(const Camera& camera, const Eigen::Vector2d& normalised);

/// The pixel of a point; none for a point at or behind the camera's plane (z <= 0).
/// The pixel may lie outside the image.
std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& x_in_cam);

/// (x/z, y/z) of the ray through a pixel: the inverse of project up to depth.
/// None where the distortion has no inverse: Newton's iteration, begun at the distorted point,
/// meets a fold of the lens model or does not converge. None for a pixel that is not finite.
std::optional<Eigen::Vector2d> normalised_from_pixel(const Camera& camera,
                                                     const Eigen::Vector2d& pixel);

/// The unit vector, in the camera frame, towards what a pixel sees. None as above.
std::optional<Eigen::Vector3d> bearing(const Camera& camera, const Eigen::Vector2d& pixel);

/// True when the pixel lies on the image at least `margin_px` inside its border.
bool is_inside(const Camera& camera, const Eigen::Vector2d& pixel, double margin_px = 0);

}  // namespace sightline
