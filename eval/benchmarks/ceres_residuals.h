// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What Ceres minimises in the benchmarks. A pose is six numbers: a rotation vector, a translation.
#pragma once

#include <Eigen/Core>
#include <ceres/rotation.h>

#include "pose/camera.h"

namespace sightline {

/// The point in the camera's frame.
template <typename T>
void move_by_ceres(const T* pose, const Eigen::Vector3d& point, T (&x)[3]) {
  const T x_in_target[3] = {T(point.x()), T(point.y()), T(point.z())};
  ceres::AngleAxisRotatePoint(pose, x_in_target, x);
  for (int i = 0; i < 3; ++i) x[i] += pose[3 + i];
}

/// The reprojection error of a point, px, of a camera without lens.
struct CeresPoint {
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
  const Camera* camera;

  template <typename T>
  bool operator()(const T* pose, T* residual) const {
    T x[3];
    move_by_ceres(pose, point, x);
    residual[0] = camera->fx_px * x[0] / x[2] + camera->cx_px - pixel.x();
    residual[1] = camera->fy_px * x[1] / x[2] + camera->cy_px - pixel.y();
    return true;
  }
};

}  // namespace sightline
