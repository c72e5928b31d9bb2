// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pose/camera.h"
#include "pose/pose.h"
#include "renderer/clip.h"
#include "renderer/visibility.h"
#include "scenes/mesh/mesh.h"

namespace sightline {

/// A curved edge is drawn as chords that leave it by less than this, px.
constexpr double kMaxChordErrorPx = 5e-4;
/// The same through a fisheye, which bends everything, so that its pieces are many.
constexpr double kMaxFisheyeChordErrorPx = 2e-3;

/// The camera's near plane, over the depth of a mesh's farthest vertex: so near that what lies
/// before it is never missed, and far enough for double precision.
constexpr double kNearFraction = 1e-9;

/// The depth about which the nearness of a scene's bodies is resolved best: that of the target's
/// origin, or, where that is not in front, of its farthest vertex, or 1. Always positive.
double reference_depth_m(const Mesh& mesh, const Pose& cam_from_mesh);

/// Puts meshes on the image plane of a camera, through its lens.
///
/// A lens bends straight edges: triangles are cut until the chords of their edges leave the true
/// curves by less than kMaxChordErrorPx, of a fisheye kMaxFisheyeChordErrorPx (their insides by 4/3
/// of that), each vertex distorted in double precision. What lies beyond the fold of the lens
/// model, where two rays would fall on one pixel, is not drawn.
///
/// Of a mesh that reaches behind the camera, the triangles that cross the plane just before it are
/// cut there (kNearFraction) and at a pyramid well around the canvas; all others are drawn whole.
class Screen {
 public:
  /// `canvas`: the pixels to be drawn, which may reach beyond the image's. `reference_m`: a depth
  /// about which nearness is resolved best.
  Screen(const Camera& camera, const PixelBox& canvas, double reference_m);

  const PixelBox& canvas() const { return canvas_; }

  /// Appends what of the mesh's triangles lies in front of the camera, but those of one-sided
  /// materials that turn their backs to it; triangle i gets the id first_id + i, all its pieces
  /// alike.
  void append(const Mesh& mesh, const Pose& cam_from_mesh, uint32_t first_id,
              ScreenMesh& out) const;

  /// (x/z, y/z) of the ray that a point of the canvas sees.
  /// Where the lens cannot be undone, that of the nearest approach known: the pixel without lens.
  Eigen::Vector2d normalised(const Eigen::Vector2d& pixel) const;

 private:
  struct LensPoint;
  ViewPyramid pyramid(double near_m) const;
  void append_cut(const std::array<Eigen::Vector3d, 3>& corners, double near_m, uint32_t id,
                  ScreenMesh& out) const;
  LensPoint add_bent_point(const Eigen::Vector2d& normalised, double nearness,
                           ScreenMesh& out) const;
  double chord_error_px(const LensPoint& a, const LensPoint& b) const;
  void append_bent(const LensPoint& a, const LensPoint& b, const LensPoint& c, uint32_t id,
                   int depth, ScreenMesh& out) const;

  Camera camera_;
  PixelBox canvas_;
  double reference_m_;
  double max_chord_error_px_ = kMaxChordErrorPx;
  double fold_radius_ = 0;                           // of the lens model, normalised
  Eigen::Vector2d min_normalised_, max_normalised_;  // of what the canvas sees
};

}  // namespace sightline
