// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/target/proposal.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/builders/cube.h"

namespace sightline {
namespace {

std::vector<FeatureProposal> propose(const Mesh& mesh, const ProposalOptions& options = {}) {
  return propose_features(mesh, Occluder(mesh), options);
}

// A ball of `rings` x 2 rings quads, each two triangles.
Mesh ball(int rings) {
  Mesh mesh;
  mesh.parts = {{"ball"}};
  const auto vertex = [&](int ring, int step) {
    const double polar = std::numbers::pi * ring / rings;
    const double around = std::numbers::pi * step / rings;
    mesh.vertices.emplace_back(std::sin(polar) * std::cos(around),
                               std::sin(polar) * std::sin(around), std::cos(polar));
    return static_cast<int>(mesh.vertices.size()) - 1;
  };
  std::vector<std::vector<int>> index(static_cast<size_t>(rings) + 1);
  for (int ring = 0; ring <= rings; ++ring) {
    const bool is_pole = ring == 0 || ring == rings;
    for (int step = 0; step < 2 * rings; ++step) {
      index[ring].push_back(is_pole && step > 0 ? index[ring][0] : vertex(ring, step));
    }
  }
  for (int ring = 0; ring < rings; ++ring) {
    for (int step = 0; step < 2 * rings; ++step) {
      const int next = (step + 1) % (2 * rings);
      const std::array<int, 4> quad = {index[ring][step], index[ring + 1][step],
                                       index[ring + 1][next], index[ring][next]};
      if (ring + 1 < rings) mesh.triangles.push_back({.vertex = {quad[0], quad[1], quad[2]}});
      if (ring > 0) mesh.triangles.push_back({.vertex = {quad[0], quad[2], quad[3]}});
    }
  }
  return mesh;
}

// A sheet within a convex outline.
Mesh sheet(std::vector<Eigen::Vector3d> outline, const std::string& name) {
  Mesh mesh;
  mesh.parts = {{name}};
  mesh.vertices = std::move(outline);
  for (int v = 2; v < static_cast<int>(mesh.vertices.size()); ++v) {
    mesh.triangles.push_back({.vertex = {0, v - 1, v}});
  }
  return mesh;
}

// A plate in the plane z = 0 between x = 0 and 2, y = 0 and 1, whose long edge at y = 1 has eight
// more vertices that lie `off_m` beside it by turns.
Mesh plate(double off_m) {
  std::vector<Eigen::Vector3d> outline = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}};
  for (int i = 8; i >= 1; --i) {
    outline.emplace_back(2.0 * i / 9, 1 + (i % 2 == 0 ? off_m : -off_m), 0);
  }
  outline.emplace_back(0, 1, 0);
  return sheet(std::move(outline), "Plate (left)");
}

// Appends an arc in the plane z = 0, in steps of some 5 degrees.
void append_arc(const Eigen::Vector2d& centre_m, double radius_m, double from_deg, double to_deg,
                std::vector<Eigen::Vector3d>& outline) {
  const int steps = static_cast<int>(std::lround((to_deg - from_deg) / 5));
  for (int i = 0; i <= steps; ++i) {
    const double turn = (from_deg + (to_deg - from_deg) * i / steps) * std::numbers::pi / 180;
    outline.emplace_back(centre_m.x() + radius_m * std::cos(turn),
                         centre_m.y() + radius_m * std::sin(turn), 0);
  }
}

void expect_cube_vertices(const std::vector<FeatureProposal>& proposals) {
  ASSERT_EQ(proposals.size(), 8u);
  std::set<std::vector<bool>> octants;
  for (const FeatureProposal& proposal : proposals) {
    const Eigen::Vector3d& p = proposal.feature.position_m;
    EXPECT_LT((p.cwiseAbs() - Eigen::Vector3d::Constant(0.5)).norm(), 1e-9);
    octants.insert({p.x() > 0, p.y() > 0, p.z() > 0});
    for (const Edge& edge : proposal.feature.edges) {
      EXPECT_EQ(edge.begin_m, p);
      EXPECT_NEAR((edge.end_m - edge.begin_m).norm(), 1, 1e-9);
    }
    // Both edges are in sight from 5 of 8 octants; from some of those at too narrow an angle.
    EXPECT_NEAR(proposal.visible_fraction, 0.6, 0.04);
    EXPECT_GT(proposal.outline_fraction, 0.3);
  }
  EXPECT_EQ(octants.size(), 8u);
}

TEST(Proposal, ACubeHasItsVertices) {
  expect_cube_vertices(propose(build_cube().mesh));
}

TEST(Proposal, WindingsDoNotMatter) {
  Mesh mesh = build_cube().mesh;
  for (size_t i = 0; i < mesh.triangles.size(); i += 2) {
    std::swap(mesh.triangles[i].vertex[0], mesh.triangles[i].vertex[1]);
  }
  expect_cube_vertices(propose(mesh));
}

TEST(Proposal, ABallHasNothing) {
  EXPECT_TRUE(propose(ball(24)).empty());
}

TEST(Proposal, NearlyStraightEdgesAreOne) {
  const double size_m = std::sqrt(5.0);
  const double straightness = ProposalOptions{}.straightness;
  const auto corners = propose(plate(0.3 * straightness * size_m));
  ASSERT_EQ(corners.size(), 4u);
  for (const FeatureProposal& corner : corners) {
    const Eigen::Vector3d& p = corner.feature.position_m;
    EXPECT_NEAR(std::abs(p.x() - 1), 1, straightness * size_m);
    EXPECT_NEAR(std::abs(p.y() - 0.5), 0.5, straightness * size_m);
    const double longer_m = std::max((corner.feature.edges[0].end_m - p).norm(),
                                     (corner.feature.edges[1].end_m - p).norm());
    EXPECT_NEAR(longer_m, 2, 1e-2);
  }
  // A zigzag far beyond the tolerance is no straight edge of that length.
  for (const FeatureProposal& corner : propose(plate(20 * straightness * size_m))) {
    for (const Edge& edge : corner.feature.edges) {
      const bool is_on_zigzag = edge.begin_m.y() > 0.9 && edge.end_m.y() > 0.9;
      EXPECT_FALSE(is_on_zigzag && (edge.end_m - edge.begin_m).norm() > 0.5);
    }
  }
}

// Else the feature has no outline, and extractors that go by the mesh have nothing to go by.
TEST(Proposal, TheMeshsOwnEdgesLieWithinTheClearanceOfThoseProposed) {
  const double size_m = std::sqrt(5.0);
  const Mesh mesh = plate(0.3 * ProposalOptions{}.straightness * size_m);
  const auto corners = propose(mesh);
  ASSERT_EQ(corners.size(), 4u);
  int without_clearance = 0;
  for (const FeatureProposal& corner : corners) {
    TargetFeature feature = corner.feature;
    const FeatureShape shape = feature_shapes(mesh, {feature}).front();
    EXPECT_FALSE(shape.edges.empty());
    for (const auto& along : shape.along) EXPECT_FALSE(along.empty());
    feature.clearance_m = 0;
    const FeatureShape bare = feature_shapes(mesh, {feature}).front();
    without_clearance += std::any_of(bare.along.begin(), bare.along.end(),
                                     [](const auto& along) { return along.empty(); });
  }
  EXPECT_GT(without_clearance, 0) << "the edges are not as bent as they should be";
}

TEST(Proposal, PartsThatMoveSaySo) {
  for (const char* name : {"Propeller", "prop.disc", "PropBlur2", "main rotor", "fan_blades",
                           "left-propdisk", "Blur", "rotors"}) {
    EXPECT_TRUE(is_moving_part(name)) << name;
  }
  for (const char* name :
       {"wing", "propulsion", "fantail", "discovery", "fanfare_1", "", "s", "12"}) {
    EXPECT_FALSE(is_moving_part(name)) << name;
  }
  std::string endless;
  while (endless.size() < 1000000) endless += "x_";
  EXPECT_FALSE(is_moving_part(endless));
  EXPECT_TRUE(is_moving_part(endless + "fan"));
}

TEST(Proposal, NamesComeFromParts) {
  std::set<std::string> names;
  for (const FeatureProposal& corner : propose(plate(0))) names.insert(corner.feature.name);
  EXPECT_THAT(names,
              testing::ElementsAre("plate_left_1", "plate_left_2", "plate_left_3", "plate_left_4"));
}

TEST(Proposal, OptionsFilter) {
  const Mesh cube = build_cube().mesh;
  EXPECT_EQ(propose(cube, {.max_features = 3}).size(), 3u);
  const auto corners_alone = [&](ProposalOptions options) {
    options.enough_corners = 0;
    return propose(cube, options).size();
  };
  EXPECT_EQ(corners_alone({.sharp_angle_deg = 95}), 0u);
  EXPECT_EQ(corners_alone({.min_length = 0.6}), 0u);  // an edge is 0.577 of the size
  EXPECT_EQ(corners_alone({.min_length = 0.57}), 8u);
  EXPECT_EQ(corners_alone({.min_visible_fraction = 0.95}), 0u);
  EXPECT_EQ(corners_alone({.min_distance = 0.6}), 4u);
}

// Appends another mesh as a part of its own.
void append_part(const Mesh& piece, const std::string& name, Mesh& to) {
  const int offset = static_cast<int>(to.vertices.size());
  to.vertices.insert(to.vertices.end(), piece.vertices.begin(), piece.vertices.end());
  for (Triangle triangle : piece.triangles) {
    for (int& v : triangle.vertex) v += offset;
    triangle.part = static_cast<int>(to.parts.size());
    to.triangles.push_back(triangle);
  }
  to.parts.push_back({name});
}

// A ball stretched along the axes and moved.
Mesh ellipsoid(const Eigen::Vector3d& half_m, const Eigen::Vector3d& centre_m) {
  Mesh mesh = ball(64);
  for (Eigen::Vector3d& v : mesh.vertices) v = half_m.cwiseProduct(v) + centre_m;
  return mesh;
}

// An aircraft without a straight edge: elliptical wings and tail.
Mesh rounded_aircraft() {
  Mesh mesh;
  append_part(ellipsoid({4, 0.55, 0.6}, {0, 0, 0}), "fuselage", mesh);
  append_part(ellipsoid({0.9, 5.5, 0.45}, {0.6, 0, 0.2}), "wing", mesh);
  append_part(ellipsoid({0.45, 1.8, 0.2}, {-3.5, 0, -0.1}), "tailplane", mesh);
  append_part(ellipsoid({0.5, 0.2, 1.1}, {-3.5, 0, -0.5}), "fin", mesh);
  return mesh;
}

TEST(Proposal, ARoundedAircraftHasItsTips) {
  const auto proposals = propose(rounded_aircraft());
  EXPECT_GE(proposals.size(), 6u);
  const double size_m = 14;
  int contours = 0;
  const std::vector<Eigen::Vector3d> tips = {{4, 0, 0},          {0.6, 5.5, 0.2},
                                             {0.6, -5.5, 0.2},   {-3.5, 1.8, -0.1},
                                             {-3.5, -1.8, -0.1}, {-3.5, 0, -1.6}};
  for (const Eigen::Vector3d& tip : tips) {
    const auto found = std::ranges::find_if(proposals, [&](const FeatureProposal& proposal) {
      return (proposal.feature.position_m - tip).norm() < 0.03 * size_m;
    });
    ASSERT_NE(found, proposals.end()) << tip.transpose();
    EXPECT_GT(found->visible_fraction, 0.4);
    EXPECT_GT(found->outline_fraction, 0.4);
    const bool is_contour = found->feature.kind == FeatureKind::kContour;
    EXPECT_EQ(is_contour, !found->feature.parts.empty());
    contours += is_contour;
  }
  EXPECT_GE(contours, 4);
  // Without them there are the few places where the mesh's own triangles make a corner.
  EXPECT_LE(propose(rounded_aircraft(), {.enough_corners = 0}).size(), 2u);
}

// Chords of an arc that are near enough to it would make corners all along it.
TEST(Proposal, ARoundedPlanformHasATipAtEveryCornerAndNothingBeside) {
  constexpr double kRadius = 0.3;
  std::vector<Eigen::Vector3d> outline;
  append_arc({0.45, 4.7}, kRadius, 55, 90, outline);
  append_arc({-0.45, 4.7}, kRadius, 90, 180, outline);
  append_arc({-0.45, -4.7}, kRadius, 180, 270, outline);
  append_arc({0.45, -4.7}, kRadius, 270, 360, outline);
  append_arc({0.45, 4.7}, kRadius, 0, 50, outline);
  Mesh mesh =
      sheet(std::move(outline), "wing");  // its long edges have their middles in the fuselage
  append_part(ellipsoid({3, 0.6, 0.6}, {0, 0, 0}), "fuselage", mesh);
  std::set<std::pair<bool, bool>> corners;
  for (const FeatureProposal& proposal : propose(mesh)) {
    if (!proposal.feature.name.starts_with("wing")) continue;
    const Eigen::Vector3d& p = proposal.feature.position_m;
    EXPECT_EQ(proposal.feature.kind, FeatureKind::kContour);
    EXPECT_NEAR(std::abs(p.x()), 0.45 + kRadius * std::sqrt(0.5), kRadius / 2);
    EXPECT_NEAR(std::abs(p.y()), 4.7 + kRadius * std::sqrt(0.5), kRadius / 2);
    EXPECT_TRUE(corners.insert({p.x() > 0, p.y() > 0}).second);
  }
  EXPECT_EQ(corners.size(), 4u);
}

TEST(Proposal, WhereAnArcEndsIsACorner) {
  const double half_m = 0.3 * std::sqrt(0.75);
  std::vector<Eigen::Vector3d> outline = {{-half_m, -5, 0}, {half_m, -5, 0}};
  append_arc({0, 4.85}, 0.3, 30, 150, outline);
  const auto corners = propose(sheet(std::move(outline), "wing"), {.enough_corners = 0});
  EXPECT_EQ(corners.size(), 4u);
  for (const FeatureProposal& corner : corners) {
    const Eigen::Vector3d& p = corner.feature.position_m;
    EXPECT_LT((p.cwiseAbs() - Eigen::Vector3d(half_m, 5, 0)).norm(), 0.03) << p.transpose();
  }
}

TEST(Proposal, ATipThatTurnsIsNoFeature) {
  Mesh mesh = rounded_aircraft();
  mesh.parts[1].name = "rotor";
  for (const FeatureProposal& proposal : propose(mesh)) {
    EXPECT_LT(std::abs(proposal.feature.position_m.y()), 5) << proposal.feature.name;
  }
}

TEST(Proposal, WhatLiesInsideIsNotProposed) {
  Mesh mesh = build_cube().mesh;
  const Mesh inner = build_cube().mesh;
  const int offset = static_cast<int>(mesh.vertices.size());
  for (const Eigen::Vector3d& v : inner.vertices) mesh.vertices.push_back(0.5 * v);
  for (Triangle triangle : inner.triangles) {
    for (int& v : triangle.vertex) v += offset;
    mesh.triangles.push_back(triangle);
  }
  expect_cube_vertices(propose(mesh));
}

TEST(Proposal, FindsWhatABuilderDeclares) {
  const auto target = load_target("boeing707");
  const auto proposals = propose_features(target->mesh, target->occluder);
  EXPECT_GE(proposals.size(), 12u);
  int declared = 0, found = 0;
  for (const TargetFeature& feature : target->features) {
    if (feature.kind != FeatureKind::kLineIntersection) continue;
    ++declared;
    const double size_m = 66;
    found += std::any_of(proposals.begin(), proposals.end(), [&](const FeatureProposal& proposal) {
      return (proposal.feature.position_m - feature.position_m).norm() < 0.002 * size_m;
    });
  }
  EXPECT_EQ(declared, 12);
  EXPECT_GE(found, 8);
}

}  // namespace
}  // namespace sightline
