// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "scenes/mesh/mesh.h"
#include "scenes/target/target.h"

namespace sightline {

/// A target as a builder makes it.
struct BuiltTarget {
  std::string name;
  std::string description;
  Mesh mesh;
  std::vector<TargetFeature> features;
  int decimals = 6;      ///< of the metres that are written
  std::string header{};  ///< comment lines that begin target.toml; the builders' own when empty
};

/// A feature at a corner of the target, with the far ends of the edges that meet there.
TargetFeature line_intersection(std::string name, const Eigen::Vector3d& corner,
                                std::span<const Eigen::Vector3d> ends);

/// A feature without straight edges: the rounded outline of these parts within `reach_m` of it
/// tells where it is, and their surface may hide it from `clearance_m` away.
TargetFeature outlined_feature(std::string name, FeatureKind kind,
                               const Eigen::Vector3d& position_m, double clearance_m,
                               std::vector<std::string> parts, double reach_m);

/// Writes mesh.glb and target.toml into the folder, which is made if need be. The same target gives
/// the same bytes. Throws InputError when a file cannot be written.
void write_target(const BuiltTarget& target, const std::filesystem::path& folder);

}  // namespace sightline
