// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/camera.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace sightline {

Camera centred_camera(int width_px, int height_px, double focal_px) {
  Camera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.fx_px = camera.fy_px = focal_px;
  camera.cx_px = 0.5 * (width_px - 1);
  camera.cy_px = 0.5 * (height_px - 1);
  return camera;
}

Eigen::Vector2d pixel_from_normalised(const Camera& camera, const Eigen::Vector2d& normalised) {
  const Eigen::Vector2d image =
      is_pinhole(camera.lens) ? normalised : distorted(camera.lens, normalised);
  Eigen::Vector2d pixel(camera.fx_px * image.x() + camera.cx_px,
                        camera.fy_px * image.y() + camera.cy_px);
  if (camera.skew_px != 0) pixel.x() += camera.skew_px * image.y();
  return pixel;
}

Eigen::Matrix2d lens_jacobian(const Camera& camera, const Eigen::Vector2d& normalised) {
  const Eigen::Vector2d focal(camera.fx_px, camera.fy_px);
  const Eigen::Matrix2d bent = distortion_jacobian(camera.lens, normalised);
  Eigen::Matrix2d jacobian = focal.asDiagonal() * bent * focal.cwiseInverse().asDiagonal();
  if (camera.skew_px != 0) {
    jacobian.row(0) += camera.skew_px * bent.row(1) * focal.cwiseInverse().asDiagonal();
  }
  return jacobian;
}

std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& x_in_cam) {
  if (!(x_in_cam.z() > 0)) return std::nullopt;
  return pixel_from_normalised(camera, x_in_cam.head<2>() / x_in_cam.z());
}

std::optional<Eigen::Vector2d> normalised_from_pixel(const Camera& camera,
                                                     const Eigen::Vector2d& pixel) {
  Eigen::Vector2d image((pixel.x() - camera.cx_px) / camera.fx_px,
                        (pixel.y() - camera.cy_px) / camera.fy_px);
  if (camera.skew_px != 0) image.x() -= camera.skew_px / camera.fx_px * image.y();
  if (!image.allFinite()) return std::nullopt;
  if (is_pinhole(camera.lens)) return image;
  return undistorted(camera.lens, image);
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
