// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "renderer/disc_shadow.h"
#include "renderer/open_sky.h"
#include "renderer/placed_body.h"
#include "renderer/shadow_map.h"
#include "scenes/scene/light.h"

namespace sightline {

/// Where a ray meets a triangle: weights of its corners, their sum 1 and none negative.
struct SurfacePoint {
  int triangle = 0;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  bool is_front = true;  ///< seen from the side that its winding calls outside
};

/// Where a ray meets a triangle's plane, moved into the triangle if it misses, by the volumes that
/// it spans with the edges opposite to the corners: their sum is the winding normal along the ray.
inline SurfacePoint surface_point(int triangle, Eigen::Vector3d volumes) {
  SurfacePoint point;
  point.triangle = triangle;
  point.is_front = volumes.sum() < 0;
  if (point.is_front) volumes = -volumes;
  volumes = volumes.cwiseMax(0);
  const double sum = volumes.sum();
  // Seen exactly edge-on there is nothing to divide by.
  point.weights = sum > 0 ? Eigen::Vector3d(volumes / sum) : Eigen::Vector3d::Constant(1.0 / 3);
  return point;
}

/// A triangle's normal by its winding, twice its area long.
Eigen::Vector3d winding_normal(const Mesh& mesh, const Triangle& triangle);

/// The same of the side that is seen.
Eigen::Vector3d facing_normal(const Mesh& mesh, const Triangle& triangle, bool is_front);

/// The normal by which a point is lit: that between its corners, of the side that is seen, of any
/// length.
Eigen::Vector3d lit_normal(const Mesh& mesh, const SurfacePoint& point);

/// What a picture in grey has of red, green and blue light: its luminance, which may exceed 1.
double grey_of(const Eigen::Vector3d& light);

/// The light as a picture in grey has it: white, and so much weaker.
Light in_grey(Light light);

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

/// How much of the distant light reaches one body. Of a light with a disc it is what a pixel's
/// samples see of 32 of its points, spread evenly over it, which they share: each looks at as many
/// as it takes for all to be seen. A narrow disc's shadows are found by rays where they may be soft
/// (disc_shadow.h), those of a wide one by a shadow map for each of its points.
class Shadow {
 public:
  static constexpr int kMaxTexels = 3072;  ///< of a side, for a point: 38 MB
  static constexpr int kDiscPoints = 32;
  static constexpr int kMaxDiscTexels = 768;  ///< for each of a disc's: 75 MB in all of a wide one

  Shadow(const std::vector<PlacedBody>& bodies, size_t receiver, const Light& light, double texel_m,
         int samples_per_pixel);

  /// From 0 to 1, as one sample of a pixel sees it. `x` lies on one of the receiver's triangles, in
  /// its frame, as `normal` does: the plane's, of any length.
  double lit_share(const Eigen::Vector3d& x, const Eigen::Vector3d& normal, int triangle,
                   int sample) const;

 private:
  bool is_lit(const Eigen::Vector3d& x, const Eigen::Vector3d& normal, int triangle,
              int point) const;

  std::vector<ShadowMap> maps_;  // of the light's middle, or of each point of a wide disc
  std::optional<DiscShadow> disc_;
  int points_ = 1;
  int samples_;
};

/// The light that one body sends to the camera.
class Shader {
 public:
  /// Without a shadow the light reaches all of the body, and without a sky, which must outlive the
  /// shader, the glow does.
  Shader(const PlacedBody& body, const Light& light, std::unique_ptr<const Shadow> shadow,
         BodySky* sky);

  /// Linear, 1 is white; highlights may exceed it. As the sample of that number sees it, where this
  /// share of the glow comes to.
  double grey(const SurfacePoint& point, int sample, double sky) const;
  /// The share of the glow that reaches a point.
  double sky_share(const SurfacePoint& point) const;

  const RayHits& hits() const { return hits_; }
  /// The light changes by more than the turn of the surface: each sample wants its own.
  bool has_detail() const;

 private:
  RayHits hits_;
  Light light_;
  Eigen::Vector3d to_light_;  // body's frame
  Eigen::Vector3d to_second_;
  std::unique_ptr<const Shadow> shadow_;
  BodySky* sky_;
};

}  // namespace sightline
