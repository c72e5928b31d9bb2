// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "pose/pose.h"
#include "renderer/visibility.h"
#include "scenes/mesh/mesh.h"
#include "scenes/scene/light.h"

namespace sightline {

/// A body as it stands before the camera. Its triangle i has the id first_id + i in a frame.
struct PlacedBody {
  const Mesh* mesh = nullptr;
  Pose cam_from_body;
  uint32_t first_id = 1;
  double stripe_contrast = 0;
  double stripe_m = 1;
};

/// Where a ray meets a triangle: weights of its corners, their sum 1 and none negative.
struct SurfacePoint {
  int triangle = 0;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  bool is_front = true;  ///< seen from the side that its winding calls outside
};

/// A triangle's normal by its winding, twice its area long.
Eigen::Vector3d winding_normal(const Mesh& mesh, const Triangle& triangle);

/// What rays from the camera meet on one body.
class RayHits {
 public:
  explicit RayHits(const PlacedBody& body);

  /// Where the ray (x/z, y/z) meets a triangle's plane, moved into the triangle if it misses.
  SurfacePoint on(int triangle, const Eigen::Vector2d& normalised) const;

  double depth_m(const SurfacePoint& point) const;
  Eigen::Vector3d in_body(const SurfacePoint& point) const;
  const PlacedBody& body() const { return body_; }
  const Eigen::Vector3d& eye_in_body() const { return eye_in_body_; }

 private:
  PlacedBody body_;
  Eigen::Matrix3d body_from_cam_;
  Eigen::Vector3d eye_in_body_;
};

/// What the light reaches of one body: all bodies drawn from the light's side onto a square map
/// that just holds this one. The border of a shadow is within half a texel of its place, along each
/// of the map's axes. The map's depth is compared on the receiving triangle's plane, at the
/// texel's centre, so that no surface shades itself.
class ShadowMap {
 public:
  /// A side has at most `max_texels`; its texels are larger than `texel_m` where that is too few.
  ShadowMap(const std::vector<PlacedBody>& bodies, size_t receiver,
            const Eigen::Vector3d& to_light_in_cam, double texel_m, int max_texels);

  /// `x` and the plane's normal, of any length, in the receiver's frame.
  bool is_lit(const Eigen::Vector3d& x, const Eigen::Vector3d& normal) const;

  double texel_m() const { return texel_m_; }

 private:
  Eigen::Matrix3d light_from_body_;
  Eigen::Vector3d origin_;  // of the map's first texel, light's axes
  double texel_m_ = 1;
  double tolerance_m_ = 0;
  int side_ = 0;
  std::vector<float> nearest_;
};

/// How much of the distant light reaches one body. Of a light with a disc the shadows of 32 of its
/// points are kept, spread evenly over it (H. Vogel, A better way to construct the sunflower head,
/// 1979), and a pixel's samples share them: each looks at as many as it takes for all to be seen.
class Shadow {
 public:
  static constexpr int kMaxTexels = 3072;  ///< of a side, for a point: 38 MB
  static constexpr int kDiscPoints = 32;
  static constexpr int kMaxDiscTexels = 768;  ///< for each point of a disc: 75 MB in all

  Shadow(const std::vector<PlacedBody>& bodies, size_t receiver, const Light& light, double texel_m,
         int samples_per_pixel);

  /// From 0 to 1, as one sample of a pixel sees it. `x` and the plane's normal, of any length, in
  /// the receiver's frame.
  double lit_share(const Eigen::Vector3d& x, const Eigen::Vector3d& normal, int sample) const;

 private:
  std::vector<ShadowMap> maps_;
  int samples_;
};

/// The light that one body sends to the camera.
class Shader {
 public:
  /// Without a shadow the light reaches all of the body.
  Shader(const PlacedBody& body, const Light& light, std::unique_ptr<const Shadow> shadow);

  /// Linear, 1 is white; highlights may exceed it. As the sample of that number sees it.
  double grey(const SurfacePoint& point, int sample) const;

  const RayHits& hits() const { return hits_; }
  /// The light changes by more than the turn of the surface: each sample wants its own.
  bool has_detail() const;

 private:
  RayHits hits_;
  Light light_;
  Eigen::Vector3d to_light_;  // body's frame
  Eigen::Vector3d to_second_;
  std::unique_ptr<const Shadow> shadow_;
};

}  // namespace sightline
