// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/camera.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace sightline {
namespace {

constexpr int kMaxUndistortIterations = 30;
/// Of the normalised coordinate: at f = 15000 px this is 1.5e-9 px.
constexpr double kUndistortTolerance = 1e-13;

}  // namespace

Camera centred_camera(int width_px, int height_px, double focal_px) {
  Camera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.fx_px = camera.fy_px = focal_px;
  camera.cx_px = 0.5 * (width_px - 1);
  camera.cy_px = 0.5 * (height_px - 1);
  return camera;
}

Eigen::Vector2d distorted(const BrownConrady& lens, const Eigen::Vector2d& normalised) {
  const double x = normalised.x();
  const double y = normalised.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  return {x * radial + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x),
          y * radial + lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y};
}

Eigen::Matrix2d distortion_jacobian(const BrownConrady& lens, const Eigen::Vector2d& normalised) {
  const double x = normalised.x();
  const double y = normalised.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  const double slope =
      2 * (lens.k1 + r2 * (2 * lens.k2 + r2 * 3 * lens.k3));  // d radial / d r2 * 2
  const double mixed = slope * x * y + 2 * lens.p1 * x + 2 * lens.p2 * y;
  Eigen::Matrix2d jacobian;
  jacobian << radial + slope * x * x + 2 * lens.p1 * y + 6 * lens.p2 * x, mixed,  //
      mixed, radial + slope * y * y + 6 * lens.p1 * y + 2 * lens.p2 * x;
  return jacobian;
}

Eigen::Matrix2d lens_jacobian(const Camera& camera, const Eigen::Vector2d& normalised) {
  const Eigen::Vector2d focal(camera.fx_px, camera.fy_px);
  return focal.asDiagonal() * distortion_jacobian(camera.distortion, normalised) *
         focal.cwiseInverse().asDiagonal();
}

std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& x_in_cam) {
  if (!(x_in_cam.z() > 0)) return std::nullopt;
  const Eigen::Vector2d image = distorted(camera.distortion, x_in_cam.head<2>() / x_in_cam.z());
  return Eigen::Vector2d(camera.fx_px * image.x() + camera.cx_px,
                         camera.fy_px * image.y() + camera.cy_px);
}

std::optional<Eigen::Vector2d> normalised_from_pixel(const Camera& camera,
                                                     const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d target((pixel.x() - camera.cx_px) / camera.fx_px,
                               (pixel.y() - camera.cy_px) / camera.fy_px);
  if (!target.allFinite()) return std::nullopt;
  if (camera.distortion.is_zero()) return target;

  Eigen::Vector2d normalised = target;
  for (int i = 0; i < kMaxUndistortIterations; ++i) {
    const Eigen::Matrix2d jacobian = distortion_jacobian(camera.distortion, normalised);
    // A fold of the lens model: beyond it two rays fall on one pixel. Beyond two folds the model
    // turns the image about, which no lens does.
    if (!(jacobian.determinant() > 0 && jacobian.trace() > 0)) return std::nullopt;
    const Eigen::Vector2d excess = distorted(camera.distortion, normalised) - target;
    const Eigen::Vector2d step = jacobian.inverse() * excess;
    normalised -= step;
    if (step.norm() <= kUndistortTolerance * (1 + normalised.norm())) return normalised;
  }
  return std::nullopt;
}

std::optional<Eigen::Vector3d> bearing(const Camera& camera, const Eigen::Vector2d& pixel) {
  const std::optional<Eigen::Vector2d> normalised = normalised_from_pixel(camera, pixel);
  if (!normalised) return std::nullopt;
  return normalised->homogeneous().normalized();
}

bool is_inside(const Camera& camera, const Eigen::Vector2d& pixel, double margin_px) {
  const double border = margin_px - 0.5;
  return pixel.x() >= border && pixel.x() <= camera.width_px - 1 - border &&  //
         pixel.y() >= border && pixel.y() <= camera.height_px - 1 - border;
}

}  // namespace sightline
