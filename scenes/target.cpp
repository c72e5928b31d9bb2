// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/target.h"

#include <set>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "scenes/assets.h"
#include "scenes/input_error.h"
#include "scenes/toml_table.h"

namespace sightline {
namespace {

constexpr double kOnFeatureM = 1e-4;  // an edge must begin at its feature to this

MeshFrame read_frame(const TomlTable& table) {
  const std::vector<std::string> axes = {"+x", "-x", "+y", "-y", "+z", "-z"};
  const MeshFrame defaults;
  return {.forward = table.choice("forward", axes, defaults.forward),
          .up = table.choice("up", axes, defaults.up),
          .unit_m = table.number("unit_m", {1e-6, 1e6}, defaults.unit_m)};
}

TargetFeature read_feature(const TomlTable& table) {
  TargetFeature feature;
  feature.name = table.text("name");
  if (feature.name.empty()) table.fail("name", "is empty");
  const std::vector<std::string> kinds = {std::string(to_string(FeatureKind::kLineIntersection)),
                                          std::string(to_string(FeatureKind::kCorner))};
  const bool has_edges = table.choice("kind", kinds) == kinds[0];
  feature.kind = has_edges ? FeatureKind::kLineIntersection : FeatureKind::kCorner;
  feature.position_m = table.vector3("position_m");
  feature.clearance_m = table.number("clearance_m", {0, 1e6}, feature.clearance_m);
  if (!has_edges) return feature;
  const auto edges = table.point_lists("edges_m", 2, 2);
  constexpr double kLeastSine = 0.01;  // half a degree: less is one edge, not two
  for (int i = 0; i < 2; ++i) {
    feature.edges[i] = {edges[i][0], edges[i][1]};
    if ((edges[i][0] - feature.position_m).norm() > kOnFeatureM) {
      table.fail("edges_m", fmt::format("edge {} must begin at position_m", i));
    }
    if ((edges[i][1] - edges[i][0]).norm() < kOnFeatureM) {
      table.fail("edges_m", fmt::format("edge {} has no length", i));
    }
  }
  const Eigen::Vector3d a = (edges[0][1] - edges[0][0]).normalized();
  const Eigen::Vector3d b = (edges[1][1] - edges[1][0]).normalized();
  if (a.cross(b).norm() < kLeastSine) table.fail("edges_m", "must not be parallel");
  return feature;
}

std::vector<TargetFeature> read_features(const TomlTable& table) {
  std::vector<TargetFeature> features;
  std::set<std::string> names;
  for (const TomlTable& entry : table.tables("feature")) {
    features.push_back(read_feature(entry));
    if (!names.insert(features.back().name).second) {
      entry.fail("name", fmt::format("\"{}\" is given twice", features.back().name));
    }
  }
  return features;
}

std::shared_ptr<const Target> make_target(std::string name, std::string description,
                                          LoadedMesh loaded, std::vector<TargetFeature> features) {
  Occluder occluder(loaded.mesh);
  return std::make_shared<const Target>(Target{std::move(name), std::move(description),
                                               std::move(loaded.mesh), loaded.cleaning,
                                               std::move(features), std::move(occluder)});
}

}  // namespace

std::string_view to_string(FeatureKind kind) {
  return kind == FeatureKind::kCorner ? "corner" : "line_intersection";
}

bool is_self_hidden(const Target& target, const TargetFeature& feature,
                    const Pose& cam_from_target) {
  const Eigen::Vector3d eye_in_target = inverse(cam_from_target).translation;
  return target.occluder.hides(feature.position_m, eye_in_target, feature.clearance_m);
}

std::shared_ptr<const Target> scaled(const std::shared_ptr<const Target>& target, double factor) {
  if (factor == 1) return target;
  LoadedMesh loaded{target->mesh, target->cleaning};
  for (Eigen::Vector3d& vertex : loaded.mesh.vertices) vertex *= factor;
  std::vector<TargetFeature> features = target->features;
  for (TargetFeature& feature : features) {
    feature.position_m *= factor;
    feature.clearance_m *= factor;
    for (Edge& edge : feature.edges) edge = {edge.begin_m * factor, edge.end_m * factor};
  }
  return make_target(target->name, target->description, std::move(loaded), std::move(features));
}

std::shared_ptr<const Target> load_target(const std::string& name_or_path, const MeshFrame& frame) {
  const std::filesystem::path file = find_target_file(name_or_path);
  if (file.extension() != ".toml") {
    return make_target(file.stem(), "", read_mesh(file, frame), {});
  }
  const TomlTable table = TomlTable::read_file(file);
  const std::string name = table.text("name");
  const std::string description = table.text("description", "");
  const TomlTable mesh = table.table("mesh");
  const std::filesystem::path mesh_file = file.parent_path() / mesh.text("file");
  const MeshFrame mesh_frame = read_frame(mesh);
  std::vector<TargetFeature> features = read_features(table);
  table.reject_unknown_keys();
  return make_target(name, description, read_mesh(mesh_file, mesh_frame), std::move(features));
}

}  // namespace sightline
