// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "scenes/mesh/mesh.h"

namespace sightline {

enum class FeatureKind {
  kLineIntersection,  ///< where two straight edges of the target meet
  kCorner,            ///< a point without straight edges, such as a nose
  kContour,           ///< a point known by a rounded outline around it, such as an engine's front
};

inline constexpr std::array kFeatureKinds = {FeatureKind::kLineIntersection, FeatureKind::kCorner,
                                             FeatureKind::kContour};

std::string_view to_string(FeatureKind kind);

/// A straight edge of the target, metres, in its frame.
struct Edge {
  Eigen::Vector3d begin_m;
  Eigen::Vector3d end_m;
};

/// A named point of a target that an extractor looks for in images.
struct TargetFeature {
  std::string name;
  FeatureKind kind = FeatureKind::kCorner;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  /// Mesh closer than this does not hide the feature: its own surface and, where that is rounded,
  /// its bulge. Mesh edges closer than this to a straight edge of the feature belong to it.
  double clearance_m = 0.01;
  /// For kLineIntersection: two edges or more, each beginning at the feature.
  std::vector<Edge> edges;
  /// Names of the mesh's parts whose outline belongs to the feature. None: for a line intersection
  /// the parts along its edges, else no outline.
  std::vector<std::string> parts;
  /// Of that outline, the stretch this near to the feature.
  double reach_m = std::numeric_limits<double>::infinity();
};

/// An edge of a mesh with the faces on its two sides.
struct MeshEdge {
  Eigen::Vector3d begin_m;  ///< in the direction in which the first face winds about it
  Eigen::Vector3d end_m;
  std::array<Eigen::Vector3d, 2> face_normal;  ///< unit; an open edge has its only face twice
  bool is_open = false;

  /// Cosine of the angle between the two faces' normals: 1 where the surface is flat.
  double cos_turn() const { return face_normal[0].dot(face_normal[1]); }
  bool is_face_towards(int face, const Eigen::Vector3d& eye_m) const {
    return face_normal[face].dot(eye_m - begin_m) > 0;
  }
};

/// What the mesh looks like around a feature: all that may become its outline in an image.
struct FeatureShape {
  std::vector<MeshEdge> edges;  ///< of the feature's parts, where they turn
  /// On each of the feature's own edges, nearest first.
  std::vector<std::vector<MeshEdge>> along;
  /// Beside each of the feature's own edges, the distance to the nearest parallel one at which the
  /// mesh turns: the width of a bevel, whose shade is its own.
  std::vector<double> bevel_m;
  Eigen::Vector3d inside_m = Eigen::Vector3d::Zero();  ///< a point amidst these edges
};

/// The shape of the mesh around each feature, in their order. A name of a part that the mesh does
/// not have is passed over.
std::vector<FeatureShape> feature_shapes(const Mesh& mesh,
                                         const std::vector<TargetFeature>& features);

}  // namespace sightline
