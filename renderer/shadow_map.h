// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "renderer/placed_body.h"

namespace sightline {

/// Rows: two axes across the light's rays, then the direction to the light, which has length 1.
Eigen::Matrix3d light_axes(const Eigen::Vector3d& to_light);

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

  /// How far the surface nearest to the light stands over a point, in the middle of its texel;
  /// negative where it lies below, or where there is none.
  double height_over_m(const Eigen::Vector3d& x) const;

  double texel_m() const { return texel_m_; }
  int side() const { return side_; }  ///< texels
  /// Of a row of texels, how near to the light the nearest surface is: z of the light's axes, from
  /// the map's origin; -FLT_MAX where there is none.
  const float* row(int row) const { return nearest_.data() + static_cast<size_t>(row) * side_; }
  const Eigen::Matrix3d& light_from_body() const { return light_from_body_; }
  const Eigen::Vector3d& origin() const { return origin_; }  ///< light's axes, the body's origin
  double tolerance_m() const { return tolerance_m_; }        ///< a surface so near does not shade

 private:
  Eigen::Matrix3d light_from_body_;
  Eigen::Vector3d origin_;  // of the map's first texel, light's axes
  double texel_m_ = 1;
  double tolerance_m_ = 0;
  int side_ = 0;
  std::vector<float> nearest_;
};

}  // namespace sightline
