// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "renderer/shadow_map.h"

namespace sightline {

/// Directions to `count` points of a light's disc, which stand for equal parts of it (H. Vogel, A
/// better way to construct the sunflower head, 1979). In the camera's axes.
std::vector<Eigen::Vector3d> points_of_disc(const Eigen::Vector3d& to_light_in_cam,
                                            double radius_deg, int count);

/// The soft shadows of a narrow disc. Rays to it rise so steeply over the shadow map of its middle
/// that they leave the sheet of surfaces which the map shows only where that sheet is torn: at an
/// outline, within the disc's radius times the height of what stands there. All other points see
/// all of the disc or nothing of it, as the map says of its middle; from the few that are left rays
/// go to points of the disc, each against the triangles that stand in its way. What is too thin for
/// the map to show is found by its edges, where it stands more than a texel over what is shown. An
/// outline over what lies so little below it that its penumbra is narrower than a fifth of a cell,
/// 0.4 texels of the map, may not be found.
class DiscShadow {
 public:
  /// Whether this body's shadows from that disc are narrow enough beside it for this way, and the
  /// triangles so few that rays take less time than a shadow map for each point of the disc.
  static bool is_narrow(const std::vector<PlacedBody>& bodies, size_t receiver,
                        const Eigen::Vector3d& to_light_in_cam, double radius_deg);

  /// `middle` is the map of the disc's middle. `points` are directions to the disc.
  DiscShadow(const std::vector<PlacedBody>& bodies, size_t receiver,
             const Eigen::Vector3d& to_light_in_cam, double radius_deg, const ShadowMap& middle,
             const std::vector<Eigen::Vector3d>& points);

  /// False where the map of the disc's middle is right for all of it. `x` as in ShadowMap.
  bool may_be_soft(const Eigen::Vector3d& x) const;

  /// Whether a point of the disc is seen from a point of one of the receiver's triangles.
  bool is_lit(const Eigen::Vector3d& x, int triangle, int point) const;

 private:
  struct Blocker {
    Eigen::Vector3d x, y, z;  // of its corners, light's axes from the map's corner
    double top = 0;           // its largest z
    int triangle = -1;        // the receiver's; -1 of another body
  };

  void mark_missed(cv::Mat& greatest, cv::Mat& is_whole) const;
  void mark_outlines(const ShadowMap& middle);
  void place_blockers(const std::vector<PlacedBody>& bodies, size_t receiver);
  void sort_blockers();
  int tile_of(double along) const;

  Eigen::Matrix3d light_from_body_;
  Eigen::Vector3d origin_;
  double tangent_ = 0;                   // of the disc's radius
  double tolerance_m_ = 0;               // a surface so near does not shade
  std::vector<Eigen::Vector2d> slopes_;  // of the rays to the points of the disc
  double cell_m_ = 1;
  cv::Mat to_outline_;  // CV_32F: cells to the nearest outline
  cv::Mat highest_;     // CV_32F: z of the highest surface within the widest penumbra
  std::vector<Blocker> blockers_;
  double tile_m_ = 1;
  int tiles_ = 1;                 // of a side
  std::vector<uint32_t> starts_;  // in sorted_, of each tile
  std::vector<uint32_t> sorted_;  // blockers_ by tile, each in all whose rays it may stop
};

}  // namespace sightline
