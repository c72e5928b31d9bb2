// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "registration/one_face.h"

#include <vector>

#include <Eigen/Geometry>

namespace sightline {

double facing_share(const Mesh& mesh, const Pose& cam_from_target) {
  constexpr double kLeastCosine = 0.985;  // of 10 degrees
  std::vector<Eigen::Vector3d> corners;
  corners.reserve(mesh.vertices.size());
  for (const Eigen::Vector3d& vertex : mesh.vertices) corners.push_back(cam_from_target * vertex);
  double facing = 0, seen = 0;
  for (const Triangle& triangle : mesh.triangles) {
    const Eigen::Vector3d& a = corners[static_cast<size_t>(triangle.vertex[0])];
    const Eigen::Vector3d& b = corners[static_cast<size_t>(triangle.vertex[1])];
    const Eigen::Vector3d& c = corners[static_cast<size_t>(triangle.vertex[2])];
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    const double towards = -normal.dot(a.normalized());
    if (!(towards > 0)) continue;
    const double area = towards / a.squaredNorm();
    seen += area;
    if (towards > kLeastCosine * normal.norm()) facing += area;
  }
  return seen > 0 ? facing / seen : 0;
}

}  // namespace sightline
