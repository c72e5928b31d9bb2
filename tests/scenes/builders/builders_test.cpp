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
#include "scenes/builders/cube.h"
#include "scenes/builders/target_file.h"
#include "scenes/random/random.h"
#include "scenes/target/target.h"

namespace sightline {

static void PrintTo(const BuiltTarget& target, std::ostream* stream) {
  *stream << target.name;
}

namespace {

constexpr double kGridM = 2e-6;  // builders round coordinates to the micrometre

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

int vertex_at(const Mesh& mesh, const Eigen::Vector3d& point) {
  for (size_t v = 0; v < mesh.vertices.size(); ++v) {
    if ((mesh.vertices[v] - point).norm() < kGridM) return static_cast<int>(v);
  }
  return -1;
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

// A triangle's corners as micrometres with y multiplied by `side`, in an order that depends on the
// triangle alone.
std::array<std::array<int64_t, 3>, 3> corners_on_side(const Mesh& mesh, const Triangle& triangle,
                                                      int side) {
  std::array<std::array<int64_t, 3>, 3> corners;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d p = mesh.vertices[triangle.vertex[i]] * 1e6;
    corners[i] = {std::llround(p.x()), side * std::llround(p.y()), std::llround(p.z())};
  }
  std::sort(corners.begin(), corners.end());
  return corners;
}

const TargetFeature& feature_named(const std::vector<TargetFeature>& features,
                                   const std::string& name) {
  const auto found = std::find_if(features.begin(), features.end(),
                                  [&](const TargetFeature& f) { return f.name == name; });
  EXPECT_NE(found, features.end()) << name;
  return *found;
}

class BuiltTargetTest : public testing::TestWithParam<BuiltTarget> {
 protected:
  const Mesh& mesh() const { return GetParam().mesh; }
};

TEST_P(BuiltTargetTest, EveryComponentIsClosed) {
  EXPECT_EQ(open_or_odd_edges(mesh()), 0);
}

TEST_P(BuiltTargetTest, EveryComponentHasPositiveVolume) {
  for (const auto& [vertex, volume_m3] : component_volumes_m3(mesh())) {
    EXPECT_GT(volume_m3, 0.01) << "at " << mesh().vertices[vertex].transpose();
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
  for (const TargetFeature& feature : GetParam().features) {
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
  const BuiltTarget& target = GetParam();
  const std::filesystem::path committed =
      std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "assets" / "targets" / target.name;
  const std::filesystem::path written =
      std::filesystem::path(testing::TempDir()) / "builders_test" / target.name;
  write_target(target, written);
  for (const char* file : {"mesh.glb", "target.toml"}) {
    ASSERT_FALSE(bytes_of(written / file).empty()) << file;
    EXPECT_TRUE(bytes_of(written / file) == bytes_of(committed / file))
        << committed / file << " is stale: run sightline_build_targets assets/targets";
  }
}

TEST_P(BuiltTargetTest, ReadsBackWhole) {
  const BuiltTarget& target = GetParam();
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "builders_test_read" / target.name;
  write_target(target, folder);
  const std::shared_ptr<const Target> read = load_target((folder / "target.toml").string());
  EXPECT_EQ(read->name, target.name);
  EXPECT_EQ(read->mesh.triangles.size(), target.mesh.triangles.size());
  EXPECT_EQ(read->mesh.vertices.size(), target.mesh.vertices.size());
  EXPECT_EQ(open_or_odd_edges(read->mesh), 0);
  ASSERT_EQ(read->features.size(), target.features.size());
  for (size_t i = 0; i < target.features.size(); ++i) {
    EXPECT_EQ(read->features[i].name, target.features[i].name);
    EXPECT_EQ(read->features[i].kind, target.features[i].kind);
    EXPECT_EQ(read->features[i].clearance_m, target.features[i].clearance_m);
    EXPECT_LT((read->features[i].position_m - target.features[i].position_m).norm(), kGridM);
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
  const TargetFeature& feature = GetParam().features.front();
  const Edge diagonal{feature.edges[0].end_m, feature.edges[1].end_m};
  EXPECT_FALSE(mesh_edges_cover(mesh(), diagonal));
}

INSTANTIATE_TEST_SUITE_P(All, BuiltTargetTest,
                         testing::Values(build_boeing707_target(), build_cube()),
                         [](const auto& param_info) { return param_info.param.name; });

class Boeing707Test : public testing::Test {
 protected:
  const Mesh mesh_ = build_boeing707();
  const std::vector<TargetFeature> features_ = boeing707_features();

  Eigen::Vector3d position(const std::string& name) const {
    return feature_named(features_, name).position_m;
  }
};

TEST_F(Boeing707Test, HasThePublishedLengthAndSpan) {
  const Bounds box = bounds(mesh_);
  EXPECT_NEAR(box.max_m.x() - box.min_m.x(), 46.61, kGridM);
  EXPECT_NEAR(box.max_m.y() - box.min_m.y(), 44.42, kGridM);
  EXPECT_NEAR(box.max_m.x(), 22.0, kGridM);
}

TEST_F(Boeing707Test, HasThePublishedFuselageWidth) {
  double half_width_m = 0;
  double rear_m = 0;
  for (const Triangle& triangle : mesh_.triangles) {
    const std::string& part = mesh_.parts[triangle.part].name;
    if (part.rfind("fuselage", 0) != 0 && part != "tail_cone") continue;
    for (const int v : triangle.vertex) {
      half_width_m = std::max(half_width_m, mesh_.vertices[v].y());
      rear_m = std::min(rear_m, mesh_.vertices[v].x());
    }
  }
  EXPECT_NEAR(2 * half_width_m, 3.76, kGridM);
  EXPECT_NEAR(22.0 - rear_m, 44.35, kGridM);
}

TEST_F(Boeing707Test, FinTipIsThePublishedHeightAboveTheGround) {
  constexpr double kGroundBelowAxisM = 3.63;
  EXPECT_NEAR(-bounds(mesh_).min_m.z() + kGroundBelowAxisM, 12.93, kGridM);
}

TEST_F(Boeing707Test, OuterWingIsSwept35DegreesAtTheQuarterChord) {
  const Boeing707 d;
  const auto quarter = [&](double y_m) {
    return Eigen::Vector3d(0.75 * d.wing_leading_edge(y_m) + 0.25 * d.wing_trailing_edge(y_m));
  };
  const Eigen::Vector3d along = quarter(d.wing_kink_y_m) - quarter(d.span_m / 2);
  EXPECT_NEAR(std::atan2(along.x(), -along.y()) / kDegree, 35, 0.1);
}

TEST_F(Boeing707Test, WingHasThePublishedDihedral) {
  for (const char* edge : {"le", "te"}) {
    const TargetFeature& tip =
        feature_named(features_, std::string("wing_tip_") + edge + "_starboard");
    const Eigen::Vector3d out = tip.edges[0].begin_m - tip.edges[0].end_m;
    EXPECT_NEAR(std::atan2(-out.z(), out.y()) / kDegree, 7, 1e-4);
  }
}

TEST_F(Boeing707Test, NoVertexOfTheWingLiesAheadOfTheLeadingEdge) {
  const Boeing707 d;
  for (const Triangle& triangle : mesh_.triangles) {
    if (mesh_.parts[triangle.part].name.rfind("wing_starboard", 0) != 0) continue;
    for (const int v : triangle.vertex) {
      const Eigen::Vector3d& p = mesh_.vertices[v];
      ASSERT_LE(p.x(), d.wing_leading_edge(p.y()).x() + kGridM);
      ASSERT_GE(p.x(), d.wing_trailing_edge(p.y()).x() - kGridM);
    }
  }
}

TEST_F(Boeing707Test, TipsArePinchedToOneCrease) {
  const double tip_y_m = Boeing707{}.span_m / 2;
  const Eigen::Vector3d le = position("wing_tip_le_starboard");
  const Eigen::Vector3d along = (position("wing_tip_te_starboard") - le).normalized();
  int on_tip = 0;
  for (const Eigen::Vector3d& v : mesh_.vertices) {
    if (v.y() < tip_y_m - kGridM) continue;
    EXPECT_LT((v - le).cross(along).norm(), kGridM);
    ++on_tip;
  }
  EXPECT_GE(on_tip, 20);
}

TEST_F(Boeing707Test, LeadingEdgesAreSmoothAndTrailingEdgesSharp) {
  const Boeing707 d;
  const int leading = vertex_at(mesh_, d.wing_leading_edge(d.wing_kink_y_m));
  const int trailing = vertex_at(mesh_, d.wing_trailing_edge(d.wing_kink_y_m));
  ASSERT_GE(leading, 0);
  ASSERT_GE(trailing, 0);
  double least_cos_leading = 1;
  double greatest_z_trailing = -1;
  double least_z_trailing = 1;
  for (const Triangle& triangle : mesh_.triangles) {
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d& normal = triangle.normal[i];
      if (triangle.vertex[i] == leading) {
        least_cos_leading = std::min(least_cos_leading, normal.normalized().x());
      }
      if (triangle.vertex[i] != trailing) continue;
      greatest_z_trailing = std::max(greatest_z_trailing, normal.z());
      least_z_trailing = std::min(least_z_trailing, normal.z());
    }
  }
  EXPECT_GT(least_cos_leading, 0.7) << "the leading edge's normals point forward";
  EXPECT_GT(greatest_z_trailing, 0.9) << "one side of the trailing edge looks down";
  EXPECT_LT(least_z_trailing, -0.9) << "the other looks up";
}

TEST_F(Boeing707Test, IsSymmetric) {
  std::multiset<std::array<std::array<int64_t, 3>, 3>> as_is;
  std::multiset<std::array<std::array<int64_t, 3>, 3>> mirrored;
  for (const Triangle& triangle : mesh_.triangles) {
    as_is.insert(corners_on_side(mesh_, triangle, 1));
    mirrored.insert(corners_on_side(mesh_, triangle, -1));
  }
  EXPECT_TRUE(as_is == mirrored);
}

TEST_F(Boeing707Test, PartsLieOnTheSideTheyAreNamedFor) {
  std::map<std::string, double> mean_y_m;
  for (const Triangle& triangle : mesh_.triangles) {
    for (const int v : triangle.vertex) {
      mean_y_m[mesh_.parts[triangle.part].name] += mesh_.vertices[v].y();
    }
  }
  for (const char* port : {"wing_port_inner", "wing_port_outer", "tailplane_port", "nacelle_1",
                           "nacelle_2", "intake_1", "exhaust_2", "pylon_1"}) {
    EXPECT_LT(mean_y_m.at(port), 0) << port;
  }
  for (const char* starboard : {"wing_starboard_inner", "wing_starboard_outer",
                                "tailplane_starboard", "nacelle_3", "nacelle_4"}) {
    EXPECT_GT(mean_y_m.at(starboard), 0) << starboard;
  }
  EXPECT_GT(mean_y_m.at("nacelle_4"), mean_y_m.at("nacelle_3"));
  EXPECT_NEAR(mean_y_m.at("fin"), 0, 1e-6);
}

TEST_F(Boeing707Test, FirstFiveFeaturesAreThePapers) {
  std::vector<std::string> names;
  for (const TargetFeature& feature : features_) names.push_back(feature.name);
  names.resize(5);
  EXPECT_THAT(names,
              testing::ElementsAre("wing_tip_le_port", "wing_tip_te_port", "wing_tip_le_starboard",
                                   "wing_tip_te_starboard", "nose"));
  EXPECT_LT(position("wing_tip_le_port").y(), 0);
  EXPECT_GT(position("wing_tip_le_port").x(), position("wing_tip_te_port").x());
}

TEST_F(Boeing707Test, NoseIsTheForemostPoint) {
  EXPECT_EQ(bounds(mesh_).max_m.x(), position("nose").x());
}

TEST_F(Boeing707Test, NoseIsStillSeenWhenItPoints35DegreesAway) {
  const Eigen::Vector3d nose = position("nose");
  for (int roll_deg = 0; roll_deg < 360; roll_deg += 10) {
    const double roll_rad = roll_deg * kDegree;
    const Eigen::Vector3d side(0, std::cos(roll_rad), std::sin(roll_rad));
    const double away_rad = 35 * kDegree;
    const Eigen::Vector3d to_camera =
        std::cos(away_rad) * side - std::sin(away_rad) * Eigen::Vector3d::UnitX();
    const Eigen::Vector3d beyond = nose + 1e-3 * to_camera;
    // The nose is convex: what leaves it outwards of one facet at the tip is outside.
    double greatest_height = -1;
    for (const Triangle& triangle : mesh_.triangles) {
      const bool is_at_tip = std::any_of(triangle.vertex.begin(), triangle.vertex.end(),
                                         [&](int v) { return mesh_.vertices[v] == nose; });
      if (!is_at_tip) continue;
      greatest_height = std::max(greatest_height, face_normal(mesh_, triangle).dot(beyond - nose));
    }
    EXPECT_GT(greatest_height, 0) << "seen from roll " << roll_deg;
  }
}

// The features that the mesh does not hide; from behind it hides the nose and the engines' fronts.
TEST_F(Boeing707Test, AtLeastFiveFeaturesAreSeenFromEverySide) {
  constexpr int kViews = 400;
  constexpr int kFewest = 5;
  const Occluder occluder(mesh_);
  size_t most_hidden = 0;
  for (int i = 0; i < kViews; ++i) {
    RandomStream stream(1, "views", static_cast<uint64_t>(i));
    const Eigen::Vector3d eye_m = 1400 * stream.rotation().col(0);
    const auto seen =
        std::count_if(features_.begin(), features_.end(), [&](const TargetFeature& feature) {
          return !occluder.hides(feature.position_m, eye_m, feature.clearance_m);
        });
    EXPECT_GE(seen, kFewest) << "from " << eye_m.transpose();
    most_hidden = std::max(most_hidden, features_.size() - static_cast<size_t>(seen));
  }
  EXPECT_GE(most_hidden, 5u) << "nothing is hidden from anywhere?";
}

TEST_F(Boeing707Test, IsSmallEnoughToRenderFast) {
  EXPECT_GT(mesh_.triangles.size(), 6000u);
  EXPECT_LT(mesh_.triangles.size(), 13000u);
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

}  // namespace
}  // namespace sightline
