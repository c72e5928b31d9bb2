// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pose/camera.h"
#include "pose/pose.h"
#include "scenes/scene/keys.h"
#include "scenes/target/target.h"

namespace sightline {

/// What a numeric study observes of its target's straight edges. Each has one edge pixel a pixel of
/// its length, all with the study's noise across the edge; nothing hides one.
struct SeenEdges {
  enum class Observed {
    kNothing,  ///< features are points with the study's noise, edges are not looked at
    kPoints,   ///< a feature is where lines meet, fitted to its edges' pixels within the reach
    kLines,    ///< each edge is a line fitted to all its pixels; there are no points
    kBoth,     ///< points as above, and lines fitted to what of each edge they leave
  };

  Observed observed = Observed::kNothing;
  double reach_px = 36;  ///< from a feature along its edges

  bool has_points() const { return observed != Observed::kLines; }
  bool has_lines() const { return observed == Observed::kLines || observed == Observed::kBoth; }
};

/// Their keys, which stand in [edges].
std::vector<Key> keys_of(SeenEdges& edges);

/// An edge of one of a target's features.
struct OwnEdge {
  int feature = 0;  ///< index into the target's
  int edge = 0;     ///< index into the feature's
};

const Edge& edge_of(const Target& target, const OwnEdge& own);

/// The edges of these features, each once, though two features have it.
std::vector<OwnEdge> different_edges(const Target& target, std::span<const int> features);

/// An edge that is seen as a line.
struct SeenEdge {
  OwnEdge of;
  double length_px = 0;  ///< of what the line is fitted to, in the middle of the edge
};

/// The edges of these features that are lines. None with an end behind the camera, and none of
/// which less than a few pixels are left.
std::vector<SeenEdge> seen_lines(const SeenEdges& edges, const Target& target,
                                 std::span<const int> features, const Camera& camera,
                                 const Pose& cam_from_target);

/// The covariance of a feature's pixel that is where the lines along its edges meet, for edge
/// pixels of that noise: the offset of a line of length L at its end has the variance 4 sigma^2 /
/// L. None of a feature without two edges that are seen apart.
std::optional<Eigen::Matrix2d> corner_covariance_px2(const SeenEdges& edges,
                                                     const TargetFeature& feature,
                                                     const Camera& camera,
                                                     const Pose& cam_from_target, double sigma_px);

}  // namespace sightline
