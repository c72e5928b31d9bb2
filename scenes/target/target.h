// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pose/pose.h"
#include "scenes/mesh/mesh_io.h"
#include "scenes/mesh/occluder.h"
#include "scenes/target/facets.h"
#include "scenes/target/feature_shape.h"
#include "scenes/target/mesh_use.h"

namespace sightline {

/// A mesh and its features, or features alone (keypoints), in the target's frame: x forward,
/// y starboard, z down, metres, so that the identity attitude shows the plan view from above with
/// the nose to the right.
struct Target {
  std::string name;
  std::string description;
  Mesh mesh;  ///< of keypoints alone: they are its vertices, and it has no triangles
  CleaningSummary cleaning;
  std::vector<TargetFeature> features;
  Occluder occluder;
  /// Of the mesh around each feature, in their order; of keypoints alone none.
  std::vector<FeatureShape> shapes = {};
  Facets facets = {};  ///< of the mesh, if it has few
  /// Turns the axes of the mesh's file into the target's; the unit is not in it.
  Eigen::Matrix3d target_from_file = Eigen::Matrix3d::Identity();

  /// False of keypoints alone: of these nothing is rendered, and nothing hides them.
  bool has_mesh() const { return !mesh.triangles.empty(); }
};

/// Why nothing of a target can be rendered, in words for the user; empty where it has a mesh.
std::string why_not_renderable(const Target& target);

/// True when the target's own mesh hides the feature from the camera, or is not drawn where the
/// feature lies: one-sided surfaces seen from behind.
bool is_self_hidden(const Target& target, const TargetFeature& feature,
                    const Pose& cam_from_target);

/// The target `factor` times as large, features and all.
std::shared_ptr<const Target> scaled(const std::shared_ptr<const Target>& target, double factor);

/// The target with a coarser mesh, which keeps this fraction of the triangles
/// (scenes/decimation.h), and the same features; itself where that is 1.
std::shared_ptr<const Target> decimated(const std::shared_ptr<const Target>& target,
                                        double kept_fraction);

/// Loads a target by name, from a target.toml, or from any mesh file (which has no features;
/// `use` says how its axes lie, which a target.toml says itself, and what of the mesh is left out).
/// A mesh file that lies over 1000 times its size from its origin, as georeferenced ones do, is
/// moved there by its middle, and its notes say so. A target.toml without [mesh] is one of
/// keypoints alone, whose features are corners unless they say otherwise. Throws InputError for
/// whatever is missing, misspelt, out of range or unreadable, and for a feature farther off the
/// mesh than its clearance and 1 % of the target's size.
std::shared_ptr<const Target> load_target(const std::string& name_or_path, const MeshUse& use = {});

}  // namespace sightline
