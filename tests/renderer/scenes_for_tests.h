// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "scenes/scene/scene.h"

namespace sightline {

inline std::shared_ptr<const Target> target_of(Mesh mesh,
                                               std::vector<TargetFeature> features = {}) {
  Occluder occluder(mesh);
  return std::make_shared<const Target>(
      Target{"test", "", std::move(mesh), {}, std::move(features), std::move(occluder)});
}

inline Pose at(double x, double y, double z, const Eigen::Vector3d& rotation_rad = {0, 0, 0}) {
  return {rotation_from_vector(rotation_rad), {x, y, z}};
}

// A white square of two triangles in z = 0, its outside towards -z.
inline Mesh plate(double side_m) {
  const double h = side_m / 2;
  Mesh mesh;
  mesh.parts = {{"plate", 1.0}};
  mesh.vertices = {{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}};
  mesh.triangles = {{.vertex = {0, 2, 1}, .part = 0}, {.vertex = {0, 3, 2}, .part = 0}};
  compute_corner_normals(mesh, 0.1);
  return mesh;
}

// White without shading on black: the image is the share of each pixel that is covered.
inline Scene coverage_scene(Mesh mesh, const Pose& cam_from_target, double focal_px = 10000) {
  for (Part& part : mesh.parts) part.albedo = 1;
  Scene scene;
  scene.target = target_of(std::move(mesh));
  scene.camera = centred_camera(512, 512, focal_px);
  scene.cam_from_target = cam_from_target;
  scene.light.ambient = 1;
  scene.light.directional = 0;
  scene.background.level = 0;
  return scene;
}

}  // namespace sightline
