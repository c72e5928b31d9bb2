// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/target/target.h"

#include <algorithm>
#include <optional>
#include <set>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "scenes/files/assets.h"
#include "scenes/files/input_error.h"
#include "scenes/files/toml_table.h"
#include "scenes/mesh/decimation.h"
#include "scenes/target/target_memory.h"

namespace sightline {
namespace {

constexpr double kOnFeatureM = 1e-4;       // an edge must begin at its feature to this
constexpr double kLeastEdgeM = 1e-9;       // less is no length
constexpr double kOffMeshFraction = 0.01;  // of the size: a virtual corner of rounded edges

MeshFrame read_frame(const TomlTable& table) {
  const std::vector<std::string> axes = {"+x", "-x", "+y", "-y", "+z", "-z", "x", "y", "z"};
  const MeshFrame defaults;
  return {.forward = table.choice("forward", axes, defaults.forward),
          .up = table.choice("up", axes, defaults.up),
          .unit_m = table.number("unit_m", {1e-6, 1e6}, defaults.unit_m)};
}

FeatureKind read_kind(const TomlTable& table, bool has_mesh) {
  std::vector<std::string> names;
  for (const FeatureKind kind : kFeatureKinds) names.emplace_back(to_string(kind));
  std::optional<std::string> fallback;
  if (!has_mesh) fallback = to_string(FeatureKind::kCorner);
  const std::string given = table.choice("kind", names, fallback);
  return *std::find_if(kFeatureKinds.begin(), kFeatureKinds.end(),
                       [&](FeatureKind kind) { return to_string(kind) == given; });
}

void check_edges(const TomlTable& table, const TargetFeature& feature) {
  constexpr double kLeastSine = 0.01;  // half a degree: less is one edge, not two
  std::vector<Eigen::Vector3d> directions;
  for (size_t i = 0; i < feature.edges.size(); ++i) {
    const Edge& edge = feature.edges[i];
    if ((edge.begin_m - feature.position_m).norm() > kOnFeatureM) {
      table.fail("edges_m",
                 fmt::format("of \"{}\": edge {} must begin at position_m", feature.name, i));
    }
    if ((edge.end_m - edge.begin_m).norm() < kLeastEdgeM) {
      table.fail("edges_m", fmt::format("of \"{}\": edge {} has no length", feature.name, i));
    }
    const Eigen::Vector3d direction = (edge.end_m - edge.begin_m).normalized();
    for (const Eigen::Vector3d& other : directions) {
      if (other.cross(direction).norm() >= kLeastSine) continue;
      table.fail("edges_m", fmt::format("of \"{}\" must not be parallel", feature.name));
    }
    directions.push_back(direction);
  }
}

// An outline is that of a mesh.
void require_no_outline(const TomlTable& table, const TargetFeature& feature) {
  if (feature.kind != FeatureKind::kContour && feature.parts.empty()) return;
  table.fail(
      feature.parts.empty() ? "kind" : "parts",
      fmt::format("of \"{}\" asks for an outline, but the target has no [mesh]", feature.name));
}

TargetFeature read_feature(const TomlTable& table, bool has_mesh) {
  TargetFeature feature;
  feature.name = table.text("name");
  if (feature.name.empty()) table.fail("name", "is empty");
  feature.kind = read_kind(table, has_mesh);
  feature.position_m = table.vector3("position_m");
  feature.clearance_m = table.number("clearance_m", {0, 1e6}, feature.clearance_m);
  feature.parts = table.texts("parts", std::vector<std::string>{});
  feature.reach_m = table.number("reach_m", {1e-6, 1e6}, feature.reach_m);
  if (!has_mesh) require_no_outline(table, feature);
  if (feature.kind == FeatureKind::kContour && feature.parts.empty()) {
    table.fail("parts", fmt::format("of \"{}\" must name the parts whose outline it is known by",
                                    feature.name));
  }
  if (feature.kind != FeatureKind::kLineIntersection) return feature;
  for (const auto& ends : table.point_lists("edges_m", 2, 2)) {
    feature.edges.push_back({ends[0], ends[1]});
  }
  check_edges(table, feature);
  return feature;
}

std::vector<TargetFeature> read_features(const TomlTable& table, bool has_mesh) {
  std::vector<TargetFeature> features;
  std::set<std::string> names;
  for (const TomlTable& entry : table.tables("feature")) {
    features.push_back(read_feature(entry, has_mesh));
    if (!names.insert(features.back().name).second) {
      entry.fail("name", fmt::format("\"{}\" is given twice", features.back().name));
    }
  }
  return features;
}

// A feature lies on the mesh, up to what its clearance allows or kOffMeshFraction of the size.
void require_on_mesh(const TomlTable& table, const Target& target) {
  const Bounds box = bounds(target.mesh);
  const double size_m = (box.max_m - box.min_m).norm();
  for (size_t i = 0; i < target.features.size(); ++i) {
    const TargetFeature& feature = target.features[i];
    const double allowed_m = std::max(feature.clearance_m, kOffMeshFraction * size_m);
    const double off_m = target.occluder.distance_m(feature.position_m);
    if (off_m <= allowed_m) continue;
    table.fail(
        fmt::format("feature[{}].position_m", i),
        fmt::format("of \"{}\" lies {:.3g} m off the mesh, may lie at most {:.3g} m off (its "
                    "clearance_m, or {} % of the target's size)",
                    feature.name, off_m, allowed_m, 100 * kOffMeshFraction));
  }
}

void check_parts(const TomlTable& table, const Mesh& mesh) {
  std::vector<std::string> known;
  for (const Part& part : mesh.parts) known.push_back(part.name);
  for (const TomlTable& entry : table.tables("feature")) {
    for (const std::string& name : entry.texts("parts", std::vector<std::string>{})) {
      if (std::find(known.begin(), known.end(), name) != known.end()) continue;
      entry.fail("parts", fmt::format("of \"{}\" holds \"{}\", which the mesh does not have{}",
                                      entry.text("name"), name, suggestion(name, known)));
    }
  }
}

// Leaves out of a mesh what is hidden, and lets its notes say how it was taken.
void take_mesh(const MeshUse& use, bool is_mesh_file, const std::filesystem::path& file,
               Mesh& mesh) {
  hide_parts(use.hidden, file, mesh);
  for (const std::string& note : {taken_note(use, is_mesh_file), take_backfaces(use, mesh)}) {
    if (!note.empty()) mesh.notes.push_back(note);
  }
}

// Far from its origin nothing is known to single precision, which models and pictures have, and no
// turn of a millionth of a radian leaves a mesh where it is: it gets an origin of its own.
void take_near_origin(Mesh& mesh) {
  constexpr double kFar = 1000;  // diagonals of its box
  const Bounds box = bounds(mesh);
  const Eigen::Vector3d middle = middle_m(mesh);
  if (middle.norm() <= kFar * (box.max_m - box.min_m).norm()) return;
  for (Eigen::Vector3d& vertex : mesh.vertices) vertex -= middle;
  mesh.notes.push_back(
      fmt::format("its coordinates lie {:.0f} m from their origin; the target's origin is their "
                  "middle, [{:.3f}, {:.3f}, {:.3f}] m",
                  middle.norm(), middle.x(), middle.y(), middle.z()));
}

std::shared_ptr<const Target> make_target(std::string name, std::string description,
                                          LoadedMesh loaded, std::vector<TargetFeature> features) {
  Occluder occluder(loaded.mesh);
  std::vector<FeatureShape> shapes;
  if (!loaded.mesh.triangles.empty()) shapes = feature_shapes(loaded.mesh, features);
  Facets facets = facets_of(loaded.mesh);
  return std::make_shared<const Target>(
      Target{std::move(name), std::move(description), std::move(loaded.mesh), loaded.cleaning,
             std::move(features), std::move(occluder), std::move(shapes), std::move(facets),
             loaded.target_from_file});
}

// Keypoints alone stand where a mesh's vertices would: for the errors of a pose, and for the room
// that the target takes.
std::shared_ptr<const Target> make_keypoints(const TomlTable& table, std::string name,
                                             std::string description,
                                             std::vector<TargetFeature> features) {
  if (features.empty()) {
    table.fail("mesh", "is missing, and so is [[feature]]: a target has a mesh, keypoints or both");
  }
  LoadedMesh none;
  for (const TargetFeature& feature : features) none.mesh.vertices.push_back(feature.position_m);
  return make_target(std::move(name), std::move(description), std::move(none), std::move(features));
}

std::shared_ptr<const Target> read_target_file(const std::string& name_or_path,
                                               const std::filesystem::path& file,
                                               const MeshUse& use) {
  if (file.extension() != ".toml") {
    LoadedMesh loaded = read_mesh(file, frame_of(use));
    take_mesh(use, true, file, loaded.mesh);
    take_near_origin(loaded.mesh);
    return make_target(file.stem(), "", std::move(loaded), {});
  }
  if (use.says_frame()) {
    throw InputError(fmt::format(
        "{}: a unit and axes (--unit, --forward, --up) are for mesh files; a target says itself "
        "how its mesh lies",
        name_or_path));
  }
  const TomlTable table = TomlTable::read_file(file);
  const std::string name = table.text("name");
  const std::string description = table.text("description", "");
  const bool has_mesh = table.has("mesh");
  std::vector<TargetFeature> features = read_features(table, has_mesh);
  if (!has_mesh) {
    table.reject_unknown_keys();
    return make_keypoints(table, name, description, std::move(features));
  }
  const TomlTable mesh = table.table("mesh");
  const std::filesystem::path mesh_file = file.parent_path() / mesh.text("file");
  const MeshFrame mesh_frame = read_frame(mesh);
  table.reject_unknown_keys();
  LoadedMesh loaded = read_mesh(mesh_file, mesh_frame);
  take_mesh(use, false, mesh_file, loaded.mesh);
  check_parts(table, loaded.mesh);
  const auto target = make_target(name, description, std::move(loaded), std::move(features));
  require_on_mesh(table, *target);
  return target;
}

}  // namespace

std::string why_not_renderable(const Target& target) {
  if (target.has_mesh()) return "";
  return fmt::format("'{}' has keypoints alone and no mesh: nothing of it can be rendered",
                     target.name);
}

bool is_self_hidden(const Target& target, const TargetFeature& feature,
                    const Pose& cam_from_target) {
  const Eigen::Vector3d eye_in_target = inverse(cam_from_target).translation;
  return target.occluder.hides_own(feature.position_m, eye_in_target, feature.clearance_m);
}

std::shared_ptr<const Target> scaled(const std::shared_ptr<const Target>& target, double factor) {
  if (factor == 1) return target;
  LoadedMesh loaded{target->mesh, target->cleaning, target->target_from_file};
  for (Eigen::Vector3d& vertex : loaded.mesh.vertices) vertex *= factor;
  std::vector<TargetFeature> features = target->features;
  for (TargetFeature& feature : features) {
    feature.position_m *= factor;
    feature.clearance_m *= factor;
    feature.reach_m *= factor;
    for (Edge& edge : feature.edges) edge = {edge.begin_m * factor, edge.end_m * factor};
  }
  return make_target(target->name, target->description, std::move(loaded), std::move(features));
}

std::shared_ptr<const Target> decimated(const std::shared_ptr<const Target>& target,
                                        double kept_fraction) {
  if (kept_fraction == 1) return target;
  return make_target(target->name, target->description,
                     {decimated(target->mesh, kept_fraction), target->cleaning}, target->features);
}

std::shared_ptr<const Target> load_target(const std::string& name_or_path, const MeshUse& use) {
  const std::filesystem::path file = find_target_file(name_or_path);
  return TargetMemory::get(file, use, [&] { return read_target_file(name_or_path, file, use); });
}

}  // namespace sightline
