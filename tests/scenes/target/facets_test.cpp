// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/target/facets.h"

#include <cmath>
#include <numbers>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "scenes/builders/boeing707.h"
#include "scenes/builders/cube.h"
#include "tests/scenes/prism.h"

namespace sightline {
namespace {

TEST(Facets, ACubeHasSixAndTwelveEdges) {
  const Mesh mesh = build_cube().mesh;
  const Facets facets = facets_of(mesh);
  ASSERT_EQ(facets.facets.size(), 6u);
  EXPECT_EQ(facets.edges.size(), 12u);
  EXPECT_TRUE(facets.is_convex);
  for (const Facet& facet : facets.facets) {
    EXPECT_TRUE(facet.is_even);
    EXPECT_NEAR(facet.normal.dot(facet.point_m), 0.5, 1e-12);
    EXPECT_TRUE(facet.is_towards(2 * facet.normal));
    EXPECT_FALSE(facet.is_towards(-2 * facet.normal));
  }
}

// Seen from outside the first facet is on the left.
TEST(Facets, EdgesRunAroundTheirLeftFacet) {
  const Facets facets = facets_of(build_cube().mesh);
  for (const FacetEdge& edge : facets.edges) {
    const Eigen::Vector3d along = edge.end_m - edge.begin_m;
    const Facet& left = facets.facets[edge.facet[0]];
    const Facet& right = facets.facets[edge.facet[1]];
    const Eigen::Vector3d middle_of_left = 0.5 * left.normal;
    const Eigen::Vector3d middle_of_right = 0.5 * right.normal;
    EXPECT_GT(left.normal.cross(along).dot(middle_of_left - edge.begin_m), 0);
    EXPECT_LT(right.normal.cross(along).dot(middle_of_right - edge.begin_m), 0);
  }
}

TEST(Facets, OfAnAngledSolidOneMayHideAnother) {
  const Mesh mesh = prism({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}});
  const Facets facets = facets_of(mesh);
  EXPECT_EQ(facets.facets.size(), 8u);
  EXPECT_FALSE(facets.is_convex);
  EXPECT_TRUE(facets_of(prism({{0, 0}, {2, 0}, {1, 2}})).is_convex);
}

TEST(Facets, PaintDividesThem) {
  Mesh mesh = build_cube().mesh;
  mesh.parts.push_back({"another", 0.3});
  mesh.triangles.front().part = static_cast<int>(mesh.parts.size()) - 1;
  EXPECT_EQ(facets_of(mesh).facets.size(), 7u);
}

TEST(Facets, OfARoundedSolidAreNotEven) {
  std::vector<Eigen::Vector2d> circle;
  for (int i = 0; i < 24; ++i) {
    const double angle = 2 * std::numbers::pi * i / 24;
    circle.emplace_back(std::cos(angle), std::sin(angle));
  }
  Mesh mesh = prism(circle);
  for (const Facet& facet : facets_of(mesh).facets) EXPECT_TRUE(facet.is_even);
  compute_corner_normals(mesh, 0.5);
  const Facets facets = facets_of(mesh);
  ASSERT_EQ(facets.facets.size(), 26u);
  for (const Facet& facet : facets.facets) {
    EXPECT_EQ(facet.is_even, std::abs(facet.normal.z()) > 0.5) << "the ends alone are flat";
  }
}

TEST(Facets, OpenOrManyAreNotHad) {
  Mesh open = build_cube().mesh;
  open.triangles.pop_back();
  EXPECT_TRUE(facets_of(open).empty());
  EXPECT_TRUE(facets_of(Mesh()).empty());
  EXPECT_TRUE(facets_of(build_boeing707()).empty());

  std::vector<Eigen::Vector2d> circle;
  for (int i = 0; i < 99; ++i) {
    const double angle = 2 * std::numbers::pi * i / 99;
    circle.emplace_back(std::cos(angle), std::sin(angle));
  }
  EXPECT_TRUE(facets_of(prism(circle)).empty()) << "101 facets";
}

TEST(Facets, OfATurnedTriangleAreNotHad) {
  Mesh mesh = build_cube().mesh;
  std::swap(mesh.triangles.front().vertex[0], mesh.triangles.front().vertex[1]);
  EXPECT_TRUE(facets_of(mesh).empty());
}

}  // namespace
}  // namespace sightline
