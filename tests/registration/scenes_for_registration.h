// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "features/prediction.h"
#include "renderer/renderer.h"
#include "scenes/scene/prior.h"
#include "tests/renderer/scenes_for_tests.h"

namespace sightline {

// A box of three different sides, so that every attitude shows greys of its own.
inline Mesh brick() {
  const Eigen::Vector3d half(0.5, 0.35, 0.25);
  Mesh mesh;
  mesh.parts = {{"x", 0.9}, {"y", 0.6}, {"z", 0.3}};
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back(half.cwiseProduct(
        Eigen::Vector3d((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1)));
  }
  const int sides[6][5] = {{0, 4, 6, 2, 0}, {1, 3, 7, 5, 0}, {0, 1, 5, 4, 1},
                           {2, 6, 7, 3, 1}, {0, 2, 3, 1, 2}, {4, 5, 7, 6, 2}};
  for (const auto& s : sides) {
    mesh.triangles.push_back({.vertex = {s[0], s[1], s[2]}, .part = s[4]});
    mesh.triangles.push_back({.vertex = {s[0], s[2], s[3]}, .part = s[4]});
  }
  compute_corner_normals(mesh, 0.1);
  return mesh;
}

// The brick, 130 px long, lit from the side, before a grey background.
inline Scene brick_scene() {
  Scene scene;
  scene.target = target_of(brick());
  scene.camera = centred_camera(256, 256, 1300);
  scene.cam_from_target = at(0.1, -0.05, 10, {0.5, 0.7, 0.2});
  scene.light.to_light_in_cam = Eigen::Vector3d(0.3, -0.4, -0.8).normalized();
  scene.background.level = 0.15;
  return scene;
}

}  // namespace sightline
