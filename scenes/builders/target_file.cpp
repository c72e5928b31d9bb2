// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/builders/target_file.h"

#include <cmath>
#include <fstream>
#include <utility>

#include <fmt/format.h>

#include "scenes/files/input_error.h"
#include "scenes/files/toml_text.h"
#include "scenes/mesh/mesh_io.h"

namespace sightline {
namespace {

constexpr const char* kHeader = R"(# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
# Written by sightline_build_targets (scenes/builders/): change the builder, not this file.
)";
constexpr const char* kConventions =
    "# Coordinates are metres in the target's frame: x forward, y starboard, z down.\n";

// Metres to so many decimals, by default the grid of the mesh's vertices; no negative zero.
double rounded(double value_m, int decimals) {
  const double steps = std::pow(10, decimals);
  return std::round(value_m * steps) / steps + 0.0;
}

std::string to_toml(const Eigen::Vector3d& p, int decimals) {
  return fmt::format("[{0:.{3}f}, {1:.{3}f}, {2:.{3}f}]", rounded(p.x(), decimals),
                     rounded(p.y(), decimals), rounded(p.z(), decimals), decimals);
}

std::string to_toml(const TargetFeature& feature, int decimals) {
  std::string text =
      fmt::format("\n[[feature]]\nname = \"{}\"\nkind = \"{}\"\nposition_m = {}\n", feature.name,
                  to_string(feature.kind), to_toml(feature.position_m, decimals));
  if (feature.clearance_m != TargetFeature{}.clearance_m) {
    text += fmt::format("clearance_m = {}\n", feature.clearance_m);
  }
  if (!feature.parts.empty()) {
    std::vector<std::string> names;
    for (const std::string& part : feature.parts) names.push_back(toml_text(part));
    text += fmt::format("parts = [{}]\n", fmt::join(names, ", "));
  }
  if (std::isfinite(feature.reach_m)) text += fmt::format("reach_m = {}\n", feature.reach_m);
  if (feature.kind != FeatureKind::kLineIntersection) return text;
  text += "edges_m = [\n";
  for (const Edge& edge : feature.edges) {
    text += fmt::format("  [{}, {}],\n", to_toml(edge.begin_m, decimals),
                        to_toml(edge.end_m, decimals));
  }
  return text + "]\n";
}

std::string to_toml(const BuiltTarget& target) {
  std::string text = target.header.empty() ? kHeader : target.header;
  text += kConventions;
  text += fmt::format("name = \"{}\"\ndescription = \"{}\"\n", target.name, target.description);
  text += "\n[mesh]\nfile = \"mesh.glb\"\nforward = \"+z\"\nup = \"+y\"\nunit_m = 1.0\n";
  for (const TargetFeature& feature : target.features) {
    text += to_toml(feature, target.decimals);
  }
  return text;
}

// What is built is closed, and its triangles are counter-clockwise from outside: nobody sees a
// back.
Mesh one_sided(Mesh mesh) {
  for (Part& part : mesh.parts) {
    if (!part.material) part.material.emplace();
    part.material->is_two_sided = false;
  }
  return mesh;
}

}  // namespace

TargetFeature line_intersection(std::string name, const Eigen::Vector3d& corner,
                                std::span<const Eigen::Vector3d> ends) {
  std::vector<Edge> edges;
  for (const Eigen::Vector3d& end : ends) edges.push_back({corner, end});
  return {.name = std::move(name),
          .kind = FeatureKind::kLineIntersection,
          .position_m = corner,
          .edges = std::move(edges),
          .parts = {}};
}

TargetFeature outlined_feature(std::string name, FeatureKind kind,
                               const Eigen::Vector3d& position_m, double clearance_m,
                               std::vector<std::string> parts, double reach_m) {
  return {.name = std::move(name),
          .kind = kind,
          .position_m = position_m,
          .clearance_m = clearance_m,
          .edges = {},
          .parts = std::move(parts),
          .reach_m = reach_m};
}

void write_target(const BuiltTarget& target, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  write_glb(one_sided(target.mesh), folder / "mesh.glb");
  const std::filesystem::path file = folder / "target.toml";
  std::ofstream stream(file, std::ios::binary);
  stream << to_toml(target);
  stream.close();
  if (!stream) throw InputError(fmt::format("{}: cannot be written", file.string()));
}

}  // namespace sightline
