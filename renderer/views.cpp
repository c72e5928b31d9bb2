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

Eigen::Vector2d polar(double radius, double angle) {
  return radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

// The i-th of so many places that cover a disc of diameter 1 evenly (H. Vogel's spiral).
Eigen::Vector2d place_in_disc(int i, int count) {
  return polar(0.5 * std::sqrt((i + 0.5) / count), i * std::numbers::pi * (3 - std::sqrt(5)));
}

// The i-th of places that do so whatever stretch of them one takes (the sequence R2 of M. Roberts),
// so that those of a moment do.
Eigen::Vector2d place_at_moment(int i) {
  constexpr double kFirst = 0.7548776662466927, kSecond = 0.5698402909980532;
  const auto fraction = [i](double step) {
    const double turns = (i + 1) * step;
    return turns - std::floor(turns);
  };
  return polar(0.5 * std::sqrt(fraction(kFirst)), 2 * std::numbers::pi * fraction(kSecond));
}

// Sees the scene from beside the middle of the opening, so that what is at the distance that is
// sharp keeps its pixels.
void move_camera(const Eigen::Vector2d& place_m, Scene& scene) {
  const Eigen::Vector3d step(place_m.x(), place_m.y(), 0);
  scene.cam_from_target.translation -= step;
  for (OtherBody& other : scene.others) other.cam_from_target.translation -= step;
  for (Lamp& lamp : scene.lamps) lamp.position_in_cam_m -= step;
  Camera& camera = scene.camera;
  const double focus_m = scene.optics.focus_m;
  camera.cx_px += (camera.fx_px * place_m.x() + camera.skew_px * place_m.y()) / focus_m;
  camera.cy_px += camera.fy_px * place_m.y() / focus_m;
}

// For how many exposures some row is exposed.
double span_of(const Scene& scene) {
  return is_rolling(scene) ? 1 + scene.motion.readout : 1;
}

}  // namespace

bool is_rolling(const Scene& scene) {
  return scene.motion.readout > 0 && !scene.motion.is_still();
}

int view_count(const Scene& scene) {
  const int moments = scene.motion.is_still() ? 1 : scene.motion.samples;
  const int places = scene.optics.has_aperture() ? scene.optics.aperture_samples : 1;
  return static_cast<int>(std::ceil(std::max(moments, places) * span_of(scene)));
}

View view_at(const Scene& scene, int index) {
  constexpr double kMetresPerMillimetre = 1e-3;
  const int count = view_count(scene);
  const double span = span_of(scene);
  View view;
  view.scene = scene;
  view.begin = span * (static_cast<double>(index) / count - 0.5);
  view.end = span * ((index + 1.0) / count - 0.5);
  if (scene.optics.has_aperture()) {
    const Eigen::Vector2d place =
        scene.motion.is_still() ? place_in_disc(index, count) : place_at_moment(index);
    move_camera(kMetresPerMillimetre * scene.optics.aperture_mm * place, view.scene);
  }
  view.cam_from_target = pose_at(view.scene, span * ((index + 0.5) / count - 0.5));
  return view;
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
