// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/scene.h"

#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace sightline {
namespace {

// Where the sides of a triangle leave the camera's front. Just before the plane they are so far
// from the image's middle that the lens means nothing.
void extend_by_crossings(const Scene& scene, const Triangle& triangle, Eigen::AlignedBox2d& box) {
  constexpr double kJustBefore = 1e-6;  // of the depth of the end in front
  const Camera& camera = scene.camera;
  for (int i = 0; i < 3; ++i) {
    Eigen::Vector3d front = scene.cam_from_target * scene.target->mesh.vertices[triangle.vertex[i]];
    Eigen::Vector3d behind =
        scene.cam_from_target * scene.target->mesh.vertices[triangle.vertex[(i + 1) % 3]];
    if (front.z() < behind.z()) std::swap(front, behind);
    if (!(front.z() > 0) || behind.z() > 0) continue;
    const double t = (1 - kJustBefore) * front.z() / (front.z() - behind.z());
    const Eigen::Vector3d x = front + t * (behind - front);
    box.extend(Eigen::Vector2d(camera.fx_px * x.x() / x.z() + camera.cx_px,
                               camera.fy_px * x.y() / x.z() + camera.cy_px));
  }
}

}  // namespace

std::string why_not_imageable(const Scene& scene) {
  if (!scene.misplaced.empty()) return scene.misplaced;
  if (scene.optics.has_aperture() && !(scene.optics.focus_m > 0)) {
    return "the target's origin, at whose distance optics.focus_m is, is behind the camera";
  }
  Eigen::AlignedBox2d pixels;
  bool is_crossing = false;
  const Mesh& mesh = scene.target->mesh;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    const auto pixel = project(scene.camera, scene.cam_from_target * vertex);
    if (pixel) {
      pixels.extend(*pixel);
    } else {
      is_crossing = true;
    }
  }
  if (pixels.isEmpty()) return "the target is behind the camera";
  if (is_crossing && mesh.triangles.empty()) return "a keypoint of the target is behind the camera";
  if (is_crossing) {
    for (const Triangle& triangle : mesh.triangles) extend_by_crossings(scene, triangle, pixels);
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
