// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/scene.h"

#include <algorithm>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace sightline {
namespace {

// False where a vertex of the target is at or behind the camera's plane.
bool is_in_front(const Target& target, const Pose& cam_from_target) {
  return std::all_of(
      target.mesh.vertices.begin(), target.mesh.vertices.end(),
      [&](const Eigen::Vector3d& vertex) { return (cam_from_target * vertex).z() > 0; });
}

}  // namespace

std::string why_not_imageable(const Scene& scene) {
  for (const OtherBody& other : scene.others) {
    if (is_in_front(*other.target, other.cam_from_target)) continue;
    return fmt::format("{} is behind the camera or reaches behind it", other.target->name);
  }
  Eigen::AlignedBox2d pixels;
  for (const Eigen::Vector3d& vertex : scene.target->mesh.vertices) {
    const auto pixel = project(scene.camera, scene.cam_from_target * vertex);
    if (!pixel) return "the target is behind the camera or reaches behind it";
    pixels.extend(*pixel);
  }
  const bool is_outside = pixels.max().x() < -0.5 || pixels.max().y() < -0.5 ||
                          pixels.min().x() > scene.camera.width_px - 0.5 ||
                          pixels.min().y() > scene.camera.height_px - 0.5;
  if (is_outside) {
    return fmt::format(
        "the target is outside the image (its pixels span u {:.0f} to {:.0f}, v "
        "{:.0f} to {:.0f}; the image is {} x {})",
        pixels.min().x(), pixels.max().x(), pixels.min().y(), pixels.max().y(),
        scene.camera.width_px, scene.camera.height_px);
  }
  return "";
}

}  // namespace sightline
