// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "pose/camera.h"
#include "pose/pose.h"
#include "renderer/visibility.h"
#include "scenes/mesh/mesh.h"

namespace sightline {

/// What a mesh alone shows of itself at a pose, split so that its picture under any distant light
/// is a sum: with an even glow a, a light l (a vector towards it, as long as it is strong) and a
/// background b the picture is a * albedo + l . albedo_normal + b * (1 - coverage). A pixel is the
/// mean over its samples, which are those of the renderer.
struct BasisImages {
  cv::Rect box;      ///< of the image; all that follows is of its size
  cv::Mat coverage;  ///< CV_32F: the part of a pixel's samples that see the mesh
  cv::Mat albedo;    ///< CV_32F
  /// CV_32F, in the camera's axes: the albedo times the unit shading normal where that is turned
  /// to the light, and zero where it is turned away.
  std::array<cv::Mat, 3> albedo_normal;
  cv::Mat front_m;  ///< CV_32FC3, in the camera: the nearest point seen; z = 0 where there is none
};

/// How basis images are drawn.
struct BasisOptions {
  int samples_per_pixel = 16;  ///< one of kSampleCounts
  int margin_px = 0;           ///< around what the mesh may touch
  /// Towards the light, of any length; none: every surface counts as turned to it.
  std::optional<Eigen::Vector3d> to_light_in_cam;
};

/// Draws basis images of one mesh before one camera with the renderer's own painter. It keeps its
/// memory between drawings and belongs to one thread.
class BasisDrawer {
 public:
  /// The mesh must outlive it.
  BasisDrawer(const Mesh& mesh, const Camera& camera);

  /// None when the mesh is not wholly in front of the camera, or touches no pixel.
  std::optional<BasisImages> draw(const Pose& cam_from_mesh, const BasisOptions& options);

  const Camera& camera() const { return camera_; }

 private:
  class PixelSums;

  const Mesh& mesh_;
  Camera camera_;
  std::unique_ptr<SamplePainter> painter_;
  ScreenMesh on_screen_;
  VisibleStrip strip_;
};

}  // namespace sightline
