// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/scene/scene.h"

#include <algorithm>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace sightline {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// False where a vertex of the target is at or behind the camera's plane.
bool is_in_front(const Target& target, const Pose& cam_from_target) {
  return std::all_of(
      target.mesh.vertices.begin(), target.mesh.vertices.end(),
      [&](const Eigen::Vector3d& vertex) { return (cam_from_target * vertex).z() > 0; });
}

}  // namespace

std::string_view to_string(BackgroundKind kind) {
  constexpr std::string_view kNames[] = {"uniform", "sky", "clouds", "stars", "image"};
  return kNames[static_cast<int>(kind)];
}

Pose draw_prior(const Pose& truth_cam_from_target, const Camera& camera, const PriorError& error,
                RandomStream& stream) {
  const Eigen::Vector3d& t = truth_cam_from_target.translation;
  Pose prior;
  prior.rotation = rotation_from_vector(error.attitude_deg * kDegree * stream.normal3()) *
                   truth_cam_from_target.rotation;
  const double range_scale = std::max(0.5, 1 + error.range_fraction * stream.normal());
  const double x_over_z = t.x() / t.z() + error.lateral_px / camera.fx_px * stream.normal();
  const double y_over_z = t.y() / t.z() + error.lateral_px / camera.fy_px * stream.normal();
  prior.translation = range_scale * t.z() * Eigen::Vector3d(x_over_z, y_over_z, 1);
  return prior;
}

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
