// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "pose/pose.h"
#include "registration/grey_image.h"
#include "renderer/basis.h"

namespace sightline {

/// A place of a mesh where an image should show an edge: on its outline, or where its surface
/// turns.
struct MeshEdgePoint {
  Eigen::Vector3d in_target_m;
  Eigen::Vector2d normal;  ///< of the edge in the image, a unit vector
  bool is_outline;
};

/// The edge points of a mesh as `images` show it at a pose, one a pixel of an edge's length. Which
/// they are holds for poses near that one, too: it is the mesh's points that are seen, not pixels.
std::vector<MeshEdgePoint> edge_points(const BasisImages& images, const Camera& camera,
                                       const Pose& cam_from_target);

/// The slopes of an image by its pixels, after a blur.
struct EdgeImage {
  EdgeImage(const GreyImage& image, double blur_px);

  cv::Mat by_x, by_y;  ///< CV_32F
};

/// The slope along a normal at a pixel, grey levels a pixel; none outside the image.
std::optional<double> slope_along(const EdgeImage& image, const Eigen::Vector2d& normal,
                                  const Eigen::Vector2d& pixel);

/// Where in (-1, 1) a parabola has its top that goes through three heights at -1, 0 and 1, the
/// middle one the highest.
double top_of_parabola(double before, double middle, double after);

/// What an edge of that slope, grey levels a pixel, is worth: slope / (slope + 6), from 0 to 1, so
/// that a few strong edges of a print do not outweigh a faint outline that fits everywhere.
double worth_of_slope(double slope);

/// How well an image shows the edges where a pose puts them: the mean worth of the slopes along the
/// points' normals. Points outside the image are worth 0.
double edge_support(const EdgeImage& image, const Camera& camera,
                    const std::vector<MeshEdgePoint>& points, const Pose& cam_from_target);

/// How far the outline stands out at the pose: the mean slope along the normal within 1 px of the
/// outline's points, over the median of the mean slopes up to 6 px aside. About 1 where the outline
/// is laid on anything else. 0 without outline points in the image.
double outline_contrast(const EdgeImage& image, const Camera& camera,
                        const std::vector<MeshEdgePoint>& points, const Pose& cam_from_target);

}  // namespace sightline
