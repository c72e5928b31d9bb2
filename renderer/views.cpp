// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "renderer/views.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pose/attitude.h"

namespace sightline {
namespace {

// The pose at a time in exposures from the middle.
Pose pose_at(const Scene& scene, double time) {
  return {rotation_from_vector(time * scene.motion.rotation_rad) * scene.cam_from_target.rotation,
          scene.cam_from_target.translation + time * scene.motion.translation_m};
}

// Of a disc of diameter 1 the i-th of places that cover it evenly, whatever stretch of them one
// takes (the sequence R2 of M. Roberts), so that those of a moment do.
Eigen::Vector2d place_in_disc(int i) {
  constexpr double kFirst = 0.7548776662466927, kSecond = 0.5698402909980532;
  const auto fraction = [i](double step) {
    const double turns = (i + 1) * step;
    return turns - std::floor(turns);
  };
  const double radius = 0.5 * std::sqrt(fraction(kFirst));
  const double angle = 2 * std::numbers::pi * fraction(kSecond);
  return radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

// Sees the scene from beside the middle of the opening, so that what is at the distance that is
// sharp keeps its pixels.
void move_camera(const Eigen::Vector2d& place_m, double focus_m, Scene& scene) {
  const Eigen::Vector3d step(place_m.x(), place_m.y(), 0);
  scene.cam_from_target.translation -= step;
  for (OtherBody& other : scene.others) other.cam_from_target.translation -= step;
  for (Lamp& lamp : scene.lamps) lamp.position_in_cam_m -= step;
  Camera& camera = scene.camera;
  camera.cx_px += (camera.fx_px * place_m.x() + camera.skew_px * place_m.y()) / focus_m;
  camera.cy_px += camera.fy_px * place_m.y() / focus_m;
}

}  // namespace

bool is_rolling(const Scene& scene) {
  return scene.motion.readout > 0 && !scene.motion.is_still();
}

std::vector<View> views_of(const Scene& scene) {
  constexpr double kMetresPerMillimetre = 1e-3;
  const bool is_still = scene.motion.is_still();
  const double span = is_rolling(scene) ? 1 + scene.motion.readout : 1;
  int count = is_still ? 1 : static_cast<int>(std::ceil(scene.motion.samples * span));
  if (scene.optics.has_aperture()) count = std::max(count, scene.optics.aperture_samples);
  const double focus_m =
      scene.optics.focus_m > 0 ? scene.optics.focus_m : scene.cam_from_target.translation.z();
  std::vector<View> views;
  for (int i = 0; i < count; ++i) {
    View& view = views.emplace_back();
    view.scene = scene;
    view.begin = span * (static_cast<double>(i) / count - 0.5);
    view.end = span * ((i + 1.0) / count - 0.5);
    if (scene.optics.has_aperture()) {
      move_camera(kMetresPerMillimetre * scene.optics.aperture_mm * place_in_disc(i), focus_m,
                  view.scene);
    }
    view.cam_from_target = pose_at(view.scene, span * ((i + 0.5) / count - 0.5));
  }
  return views;
}

double share_of(const View& view, const Scene& scene, int row, int rows) {
  const double place = rows > 1 ? static_cast<double>(row) / (rows - 1) - 0.5 : 0;
  const double middle = scene.motion.readout * place;
  return std::max(0.0, std::min(view.end, middle + 0.5) - std::max(view.begin, middle - 0.5));
}

Camera scaled(Camera camera, double part) {
  camera.fx_px *= 1 + part;
  camera.fy_px *= 1 + part;
  camera.skew_px *= 1 + part;
  return camera;
}

}  // namespace sightline
