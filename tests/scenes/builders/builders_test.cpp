// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <numeric>
#include <ostream>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pose/angles.h"
#include "scenes/builders/boeing707.h"
#include "scenes/builders/boeing707_livery.h"
#include "scenes/builders/cube.h"
#include "scenes/builders/tango.h"
#include "scenes/builders/target_file.h"
#include "scenes/target/target.h"
#include "tests/scenes/builders/built_mesh.h"

namespace sightline {

namespace {

// A target is built in the tests that look at it, for some take a while.
struct TargetBuilder {
  std::string name;
  BuiltTarget (*build)();
};

void PrintTo(const TargetBuilder& builder, std::ostream* stream) {
  *stream << builder.name;
}

using DirectedEdge = std::pair<int, int>;

std::map<DirectedEdge, int> directed_edges(const Mesh& mesh) {
  std::map<DirectedEdge, int> count;
  for (const Triangle& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) ++count[{triangle.vertex[i], triangle.vertex[(i + 1) % 3]}];
  }
  return count;
}

// Edges that are not in exactly two triangles, once in each direction.
int open_or_odd_edges(const Mesh& mesh) {
  const std::map<DirectedEdge, int> edges = directed_edges(mesh);
  return static_cast<int>(std::count_if(edges.begin(), edges.end(), [&](const auto& entry) {
    const auto opposite = edges.find({entry.first.second, entry.first.first});
    return entry.second != 1 || opposite == edges.end() || opposite->second != 1;
  }));
}

// The connected component of each vertex, named by one of its vertices.
std::vector<int> components(const Mesh& mesh) {
  std::vector<int> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& triangle : mesh.triangles) {
    parent[root(triangle.vertex[1])] = root(triangle.vertex[0]);
    parent[root(triangle.vertex[2])] = root(triangle.vertex[0]);
  }
  std::vector<int> component;
  for (size_t v = 0; v < parent.size(); ++v) component.push_back(root(static_cast<int>(v)));
  return component;
}

std::map<int, double> component_volumes_m3(const Mesh& mesh) {
  const std::vector<int> component = components(mesh);
  std::map<int, double> volumes;
  for (const Triangle& triangle : mesh.triangles) {
    const auto& [a, b, c] = triangle.vertex;
    volumes[component[a]] += mesh.vertices[a].dot(mesh.vertices[b].cross(mesh.vertices[c])) / 6;
  }
  return volumes;
}

// The smallest of a triangle's three heights.
double height_m(const Mesh& mesh, const Triangle& triangle) {
  const Eigen::Vector3d a = mesh.vertices[triangle.vertex[1]] - mesh.vertices[triangle.vertex[0]];
  const Eigen::Vector3d b = mesh.vertices[triangle.vertex[2]] - mesh.vertices[triangle.vertex[0]];
  return a.cross(b).norm() / std::max({a.norm(), b.norm(), (b - a).norm()});
}

// Whether edges of the mesh, all within the grid of the straight segment, lead from one of its ends
// to the other.
bool mesh_edges_cover(const Mesh& mesh, const Edge& segment) {
  const Eigen::Vector3d direction = (segment.end_m - segment.begin_m).normalized();
  std::set<int> on_line;
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Eigen::Vector3d from_begin = mesh.vertices[v] - segment.begin_m;
    if (from_begin.cross(direction).norm() < kGridM) on_line.insert(static_cast<int>(v));
  }
  std::multimap<int, int> neighbours;
  for (const auto& [edge, count] : directed_edges(mesh)) {
    if (on_line.contains(edge.first) && on_line.contains(edge.second)) neighbours.insert(edge);
  }
  const int end = vertex_at(mesh, segment.end_m);
  std::vector<int> open = {vertex_at(mesh, segment.begin_m)};
  std::set<int> reached(open.begin(), open.end());
  while (!open.empty()) {
    const int v = open.back();
    open.pop_back();
    const auto [first, last] = neighbours.equal_range(v);
    for (auto it = first; it != last; ++it) {
      if (reached.insert(it->second).second) open.push_back(it->second);
    }
  }
  return end >= 0 && reached.contains(end);
}

std::vector<char> bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

class BuiltTargetTest : public testing::TestWithParam<TargetBuilder> {
 protected:
  const BuiltTarget target_ = GetParam().build();

  const Mesh& mesh() const { return target_.mesh; }
};

// The only texture that a target has.
const Texture& texture_of(const Mesh& mesh) {
  return *mesh.textures.at(0);
}

TEST_P(BuiltTargetTest, EveryComponentIsClosed) {
  EXPECT_EQ(open_or_odd_edges(mesh()), 0);
}

TEST_P(BuiltTargetTest, EveryComponentHasPositiveVolume) {
  for (const auto& [vertex, volume_m3] : component_volumes_m3(mesh())) {
    EXPECT_GT(volume_m3, 1e-5) << "at " << mesh().vertices[vertex].transpose();
  }
}

TEST_P(BuiltTargetTest, CornerNormalsAreUnitAndAgreeWithTheWinding) {
  const double cos_crease = std::cos(60 * kDegree);
  for (const Triangle& triangle : mesh().triangles) {
    for (const Eigen::Vector3d& normal : triangle.normal) {
      ASSERT_NEAR(normal.norm(), 1, 1e-12);
      ASSERT_GT(normal.dot(face_normal(mesh(), triangle)), cos_crease);
    }
  }
}

TEST_P(BuiltTargetTest, HasNoDegenerateTriangles) {
  for (const Triangle& triangle : mesh().triangles) {
    ASSERT_GT(height_m(mesh(), triangle), 1e-3) << mesh().parts[triangle.part].name << " at "
                                                << mesh().vertices[triangle.vertex[0]].transpose();
  }
}

TEST_P(BuiltTargetTest, CoincidentPointsAreOneVertex) {
  std::set<std::tuple<double, double, double>> points;
  for (const Eigen::Vector3d& v : mesh().vertices) points.insert({v.x(), v.y(), v.z()});
  EXPECT_EQ(points.size(), mesh().vertices.size());
}

TEST_P(BuiltTargetTest, EveryPartIsUsedAndNamedOnce) {
  std::set<int> used;
  std::set<std::string> names;
  for (const Triangle& triangle : mesh().triangles) used.insert(triangle.part);
  for (const Part& part : mesh().parts) names.insert(part.name);
  EXPECT_EQ(used.size(), mesh().parts.size());
  EXPECT_EQ(names.size(), mesh().parts.size());
}

// Shades are albedo (0.30 + 0.75 max(0, n.l)); backgrounds stand at 0.15.
TEST_P(BuiltTargetTest, NoPartCanHaveTheShadeOfTheBackground) {
  constexpr double kBackground = 0.15;
  for (const Part& part : mesh().parts) {
    const bool is_light = part.albedo >= 0.70 && part.albedo * 0.30 > kBackground;
    const bool is_dark = part.albedo <= 0.12 && part.albedo * 1.05 < kBackground;
    EXPECT_TRUE(is_light || is_dark) << part.name << " " << part.albedo;
    EXPECT_LE(part.albedo * 1.05, 1) << part.name << " saturates";
  }
}

TEST_P(BuiltTargetTest, FeaturesAreVerticesAndTheirEdgesAreEdgesOfTheMesh) {
  for (const TargetFeature& feature : target_.features) {
    if (feature.kind == FeatureKind::kContour) continue;
    EXPECT_GE(vertex_at(mesh(), feature.position_m), 0) << feature.name;
    if (feature.kind != FeatureKind::kLineIntersection) continue;
    for (const Edge& edge : feature.edges) {
      EXPECT_EQ(edge.begin_m, feature.position_m) << feature.name;
      EXPECT_TRUE(mesh_edges_cover(mesh(), edge)) << feature.name;
    }
  }
}

TEST_P(BuiltTargetTest, AssetsAreWhatTheBuilderWrites) {
  const std::filesystem::path committed =
      std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "assets" / "targets" / target_.name;
  const std::filesystem::path written =
      std::filesystem::path(testing::TempDir()) / "builders_test" / target_.name;
  write_target(target_, written);
  for (const char* file : {"mesh.glb", "target.toml"}) {
    ASSERT_FALSE(bytes_of(written / file).empty()) << file;
    EXPECT_TRUE(bytes_of(written / file) == bytes_of(committed / file))
        << committed / file << " is stale: run sightline_build_targets assets/targets";
  }
}

TEST_P(BuiltTargetTest, ReadsBackWhole) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "builders_test_read" / target_.name;
  write_target(target_, folder);
  const std::shared_ptr<const Target> read = load_target((folder / "target.toml").string());
  EXPECT_EQ(read->name, target_.name);
  EXPECT_EQ(read->mesh.triangles.size(), target_.mesh.triangles.size());
  EXPECT_EQ(read->mesh.vertices.size(), target_.mesh.vertices.size());
  EXPECT_EQ(open_or_odd_edges(read->mesh), 0);
  ASSERT_EQ(read->features.size(), target_.features.size());
  for (size_t i = 0; i < target_.features.size(); ++i) {
    EXPECT_EQ(read->features[i].name, target_.features[i].name);
    EXPECT_EQ(read->features[i].kind, target_.features[i].kind);
    EXPECT_EQ(read->features[i].clearance_m, target_.features[i].clearance_m);
    EXPECT_LT((read->features[i].position_m - target_.features[i].position_m).norm(), kGridM);
  }
}

TEST_P(BuiltTargetTest, ChecksNoticeAHoleAndAFlippedTriangle) {
  Mesh with_hole = mesh();
  with_hole.triangles.pop_back();
  EXPECT_EQ(open_or_odd_edges(with_hole), 3);
  Mesh with_flip = mesh();
  std::swap(with_flip.triangles[0].vertex[0], with_flip.triangles[0].vertex[1]);
  EXPECT_GT(open_or_odd_edges(with_flip), 0);
}

TEST_P(BuiltTargetTest, ChecksNoticeAnEdgeThatIsNotInTheMesh) {
  const TargetFeature& feature = target_.features.front();
  const Edge diagonal{feature.edges[0].end_m, feature.edges[1].end_m};
  EXPECT_FALSE(mesh_edges_cover(mesh(), diagonal));
}

INSTANTIATE_TEST_SUITE_P(
    All, BuiltTargetTest,
    testing::Values(TargetBuilder{"boeing707", [] { return build_boeing707_target(); }},
                    TargetBuilder{"boeing707_livery",
                                  [] { return build_boeing707_livery_target(); }},
                    TargetBuilder{"cube", [] { return build_cube(); }},
                    TargetBuilder{"tango", [] { return build_tango(); }}),
    [](const auto& param_info) { return param_info.param.name; });

// What a study of either stands on.
TEST(Boeing707Livery, HasTheShapePartsAndFeaturesOfThePlainTarget) {
  const auto plain = load_target("boeing707");
  const auto painted = load_target("boeing707_livery");
  EXPECT_EQ(painted->mesh.vertices, plain->mesh.vertices);
  ASSERT_EQ(painted->mesh.triangles.size(), plain->mesh.triangles.size());
  for (size_t t = 0; t < plain->mesh.triangles.size(); ++t) {
    ASSERT_EQ(painted->mesh.triangles[t].vertex, plain->mesh.triangles[t].vertex);
    ASSERT_EQ(painted->mesh.triangles[t].part, plain->mesh.triangles[t].part);
    ASSERT_EQ(painted->mesh.triangles[t].normal, plain->mesh.triangles[t].normal);
  }
  ASSERT_EQ(painted->mesh.parts.size(), plain->mesh.parts.size());
  for (size_t i = 0; i < plain->mesh.parts.size(); ++i) {
    EXPECT_EQ(painted->mesh.parts[i].name, plain->mesh.parts[i].name);
    EXPECT_NEAR(painted->mesh.parts[i].albedo, plain->mesh.parts[i].albedo, 1e-12);
  }
  ASSERT_EQ(painted->features.size(), plain->features.size());
  for (size_t i = 0; i < plain->features.size(); ++i) {
    EXPECT_EQ(painted->features[i].name, plain->features[i].name);
    EXPECT_EQ(painted->features[i].position_m, plain->features[i].position_m);
    EXPECT_EQ(painted->features[i].parts, plain->features[i].parts);
  }
}

TEST(Boeing707Livery, ItsTextureSurvivesTheFile) {
  const Mesh built = build_boeing707_livery_target().mesh;
  const Mesh read = load_target("boeing707_livery")->mesh;
  EXPECT_TRUE(texture_of(read).rgba == texture_of(built).rgba);
  ASSERT_EQ(read.coats.size(), read.triangles.size());
  // Parts and their triangles come back in their order.
  std::vector<size_t> by_part(built.triangles.size());
  std::iota(by_part.begin(), by_part.end(), 0);
  std::stable_sort(by_part.begin(), by_part.end(), [&](size_t a, size_t b) {
    return built.triangles[a].part < built.triangles[b].part;
  });
  for (size_t t = 0; t < by_part.size(); ++t) {
    for (int c = 0; c < 3; ++c) {
      ASSERT_EQ(read.coats[t].uv[c], built.coats[by_part[t]].uv[c]) << t;
      ASSERT_GE(read.coats[t].uv[c].minCoeff(), 0);
      ASSERT_LE(read.coats[t].uv[c].maxCoeff(), 1);
    }
  }
  const auto folder = std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "assets" / "targets";
  EXPECT_LT(std::filesystem::file_size(folder / "boeing707_livery" / "mesh.glb"),
            std::filesystem::file_size(folder / "boeing707" / "mesh.glb") + 300'000);
}

TEST(Boeing707Livery, NeitherSideShowsItsTextureMirrored) {
  const Mesh mesh = build_boeing707_livery_target().mesh;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& triangle = mesh.triangles[t];
    if (mesh.parts[triangle.part].name != "fuselage_upper") continue;
    const Coat& coat = mesh.coats[t];
    const Eigen::Vector2f a = coat.uv[1] - coat.uv[0];
    const Eigen::Vector2f b = coat.uv[2] - coat.uv[0];
    // Counter-clockwise from outside is clockwise in a picture whose v goes down.
    ASSERT_LE(a.x() * b.y() - a.y() * b.x(), 1e-9) << t;
  }
}

TEST(Cube, HasUnitEdgesAndItsCentreAtTheOrigin) {
  const Bounds box = bounds(build_cube().mesh);
  EXPECT_EQ(box.min_m, Eigen::Vector3d::Constant(-0.5));
  EXPECT_EQ(box.max_m, Eigen::Vector3d::Constant(0.5));
}

TEST(Cube, FacesAreFlatAndOfDifferentShades) {
  const Mesh mesh = build_cube().mesh;
  for (const Triangle& triangle : mesh.triangles) {
    for (const Eigen::Vector3d& normal : triangle.normal) {
      EXPECT_EQ(normal, face_normal(mesh, triangle));
    }
  }
  std::set<double> albedos;
  for (const Part& part : mesh.parts) albedos.insert(part.albedo);
  EXPECT_EQ(albedos.size(), 6u);
}

TEST(Cube, VertexNumbersAreTheBitsOfTheirSigns) {
  const std::vector<TargetFeature> features = build_cube().features;
  ASSERT_EQ(features.size(), 8u);
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(features[i].name, "vertex_" + std::to_string(i));
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(features[i].position_m[axis] > 0, (i >> axis & 1) != 0);
    }
  }
}

// In the order of the points that SPEED+'s baseline publishes.
TEST(Tango, HasTheKeypointsOfSpeedPlus) {
  const std::vector<TargetFeature> features = build_tango().features;
  ASSERT_EQ(features.size(), 11u);
  const std::map<size_t, Eigen::Vector3d> known = {
      {0, {-0.37, -0.385, 0.3215}}, {2, {0.37, 0.385, 0.3215}},     {4, {-0.37, -0.264, 0}},
      {6, {0.37, 0.304, 0}},        {8, {-0.5427, 0.4877, 0.2535}}, {10, {0.305, -0.579, 0.2515}}};
  for (const auto& [i, point] : known) {
    EXPECT_EQ(features[i].position_m, point) << features[i].name;
    EXPECT_NE(features[(i + 1) % features.size()].position_m, point);
  }
}

TEST(Tango, ItsMaterialsSurviveTheFile) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "tango_read";
  const BuiltTarget tango = build_tango();
  write_target(tango, folder);
  const auto read = load_target((folder / "target.toml").string());
  ASSERT_EQ(read->mesh.parts.size(), tango.mesh.parts.size());
  std::set<double> metallic;
  for (size_t i = 0; i < tango.mesh.parts.size(); ++i) {
    const Part& built = tango.mesh.parts[i];
    const Part& part = read->mesh.parts[i];
    ASSERT_TRUE(part.material && built.material) << built.name;
    EXPECT_EQ(part.material->base, built.material->base) << built.name;
    EXPECT_TRUE(part.material->has_gloss) << built.name;
    EXPECT_EQ(part.material->metallic, built.material->metallic) << built.name;
    EXPECT_EQ(part.material->roughness, built.material->roughness) << built.name;
    metallic.insert(part.material->metallic);
  }
  EXPECT_EQ(metallic.size(), 2u);  // foil and rods are metal, cells are not
}

TEST(Tango, FoilIsCreasedAndCellsAreFlat) {
  const Mesh mesh = build_tango().mesh;
  std::map<std::string, double> largest;
  for (const Triangle& triangle : mesh.triangles) {
    double& angle = largest[mesh.parts[triangle.part].name];
    for (const Eigen::Vector3d& normal : triangle.normal) {
      angle = std::max(angle, std::acos(std::min(1.0, normal.dot(face_normal(mesh, triangle)))));
    }
  }
  EXPECT_GT(largest.at("foil_gold"), 10 * kDegree);
  EXPECT_LT(largest.at("solar_cells"), 1e-6);
}

}  // namespace
}  // namespace sightline
