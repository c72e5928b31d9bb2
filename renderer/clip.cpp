// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/clip.h"

#include <algorithm>
#include <tuple>

namespace sightline {
namespace {

// A point is inside where normal . x >= offset.
struct ClipPlane {
  Eigen::Vector3d normal;
  double offset = 0;

  double height(const Eigen::Vector3d& x) const { return normal.dot(x) - offset; }
};

std::array<ClipPlane, 5> planes_of(const ViewPyramid& pyramid) {
  return {{{{0, 0, 1}, pyramid.near_m},
           {{1, 0, -pyramid.low.x()}, 0},
           {{-1, 0, pyramid.high.x()}, 0},
           {{0, 1, -pyramid.low.y()}, 0},
           {{0, -1, pyramid.high.y()}, 0}}};
}

bool is_before(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::tuple(a.x(), a.y(), a.z()) < std::tuple(b.x(), b.y(), b.z());
}

// Where an edge meets the plane, computed in one order whichever triangle asks.
Eigen::Vector3d meeting_point(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                              const ClipPlane& plane) {
  const Eigen::Vector3d& from = is_before(a, b) ? a : b;
  const Eigen::Vector3d& to = is_before(a, b) ? b : a;
  const double above = plane.height(from);
  return from + (to - from) * (above / (above - plane.height(to)));
}

std::vector<Eigen::Vector3d> cut(const std::vector<Eigen::Vector3d>& polygon,
                                 const ClipPlane& plane) {
  std::vector<Eigen::Vector3d> kept;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d& from = polygon[i];
    const Eigen::Vector3d& to = polygon[(i + 1) % polygon.size()];
    const bool is_from_inside = plane.height(from) >= 0;
    if (is_from_inside) kept.push_back(from);
    if (is_from_inside != (plane.height(to) >= 0)) kept.push_back(meeting_point(from, to, plane));
  }
  return kept;
}

}  // namespace

std::vector<Eigen::Vector3d> clipped(const std::array<Eigen::Vector3d, 3>& triangle,
                                     const ViewPyramid& pyramid) {
  std::vector<Eigen::Vector3d> polygon(triangle.begin(), triangle.end());
  for (const ClipPlane& plane : planes_of(pyramid)) polygon = cut(polygon, plane);
  if (polygon.size() < 3) polygon.clear();
  // The point where an edge meets the first plane is on its near side by rounding at the most.
  for (Eigen::Vector3d& corner : polygon) corner.z() = std::max(corner.z(), pyramid.near_m);
  return polygon;
}

}  // namespace sightline
