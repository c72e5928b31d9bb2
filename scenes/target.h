// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "pose/pose.h"
#include "scenes/mesh_io.h"
#include "scenes/occluder.h"

namespace sightline {

enum class FeatureKind {
  kLineIntersection,  ///< where two straight edges of the target meet
  kCorner,            ///< a point without straight edges, such as a nose
};

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
  /// Mesh closer than this to the feature does not hide it: its own surface, and where that is
  /// rounded, the bulge between the feature and the outline that is seen in its place.
  double clearance_m = 0.01;
  /// For kLineIntersection: the two edges, each beginning at the feature.
  std::array<Edge, 2> edges;
};

/// A mesh and its features, in the target's frame: x forward, y starboard, z down, metres, so that
/// the identity attitude shows the plan view from above with the nose to the right.
struct Target {
  std::string name;
  std::string description;
  Mesh mesh;
  CleaningSummary cleaning;
  std::vector<TargetFeature> features;
  Occluder occluder;
};

/// True when the target's own mesh hides the feature from the camera.
bool is_self_hidden(const Target& target, const TargetFeature& feature,
                    const Pose& cam_from_target);

/// The target `factor` times as large, features and all.
std::shared_ptr<const Target> scaled(const std::shared_ptr<const Target>& target, double factor);

/// Loads a target by name, from a target.toml, or from any mesh file (which has no features;
/// `frame` is how the mesh's axes lie, a target.toml says it itself). Throws InputError for
/// whatever is missing, misspelt, out of range or unreadable.
std::shared_ptr<const Target> load_target(const std::string& name_or_path,
                                          const MeshFrame& frame = {});

}  // namespace sightline
