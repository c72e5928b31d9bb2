// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/trial/metrics.h"

#include <algorithm>
#include <limits>

namespace sightline {

VertexErrors vertex_errors(const Mesh& mesh, const Camera& camera, const Pose& estimated,
                           const Pose& truth) {
  VertexErrors errors;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    const Eigen::Vector3d x_estimated = estimated * vertex;
    const Eigen::Vector3d x_true = truth * vertex;
    const double distance_m = (x_estimated - x_true).norm();
    errors.add_m += distance_m;
    errors.mssd_m = std::max(errors.mssd_m, distance_m);
    const auto pixel_estimated = project(camera, x_estimated);
    const auto pixel_true = project(camera, x_true);
    const double distance_px = pixel_estimated && pixel_true
                                   ? (*pixel_estimated - *pixel_true).norm()
                                   : std::numeric_limits<double>::infinity();
    errors.mspd_px = std::max(errors.mspd_px, distance_px);
  }
  errors.add_m /= static_cast<double>(mesh.vertices.size());
  return errors;
}

}  // namespace sightline
