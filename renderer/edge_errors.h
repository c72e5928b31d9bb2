// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "renderer/renderer.h"

namespace sightline {

/// One edge of a convex target's outline: where the camera puts its ends, and where the image has
/// it, row by row or column by column.
struct OutlineEdge {
  Eigen::Vector2d begin, end;             ///< projected vertices of the convex hull, in its order
  std::vector<Eigen::Vector2d> measured;  ///< points of the edge in the image
  double position_error_px = 0;           ///< mean distance of those from the edge, signed
  double slope = 0;                       ///< 0 along an axis, 1 along a diagonal
};

/// The outline of a scene's convex main target, white on black and free of distortion, in its
/// linear image: the light of a few pixels across an edge says where it passes. Edges too short to
/// be measured have no points.
std::vector<OutlineEdge> measure_outline(const Scene& scene, const cv::Mat& linear);

/// How far edges and vertices of a cube lie from where the camera says, px, root mean square.
struct EdgeErrors {
  double general_px = 0;  ///< of edges at more than 3 degrees to both axes
  double axis_px = 0;     ///< of edges along an axis
  double vertex_px = 0;   ///< of two edges' intersections
  int general_count = 0, axis_count = 0, vertex_count = 0;
};

/// Measures a renderer on a unit cube, 170 px wide, in `poses` poses of each kind.
EdgeErrors measure_edge_errors(Renderer& renderer, int samples_per_pixel, int poses);

/// What is promised of a number of samples: limits of general_px, axis_px and vertex_px.
EdgeErrors promised_edge_errors(int samples_per_pixel);

}  // namespace sightline
