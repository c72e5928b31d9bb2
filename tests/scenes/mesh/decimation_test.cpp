// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/decimation.h"

#include <algorithm>
#include <map>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "scenes/builders/boeing707.h"
#include "scenes/builders/cube.h"
#include "scenes/target/target.h"

namespace sightline {
namespace {

double area_m2(const Mesh& mesh, const Triangle& triangle) {
  const Eigen::Vector3d& a = mesh.vertices[triangle.vertex[0]];
  const Eigen::Vector3d& b = mesh.vertices[triangle.vertex[1]];
  const Eigen::Vector3d& c = mesh.vertices[triangle.vertex[2]];
  return (b - a).cross(c - a).norm() / 2;
}

std::map<std::string, double> area_of_parts_m2(const Mesh& mesh) {
  std::map<std::string, double> areas;
  for (const Triangle& triangle : mesh.triangles) {
    areas[mesh.parts[triangle.part].name] += area_m2(mesh, triangle);
  }
  return areas;
}

// The greatest distance of a vertex from the surface of a mesh.
double farthest_m(const Mesh& mesh, const Occluder& surface) {
  double farthest = 0;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    farthest = std::max(farthest, surface.distance_m(vertex));
  }
  return farthest;
}

TEST(Decimation, KeepsAboutTheFractionAskedForAndTheShape) {
  const Mesh mesh = build_boeing707();
  const Occluder surface(mesh);
  double before_m = 0;
  for (const double kept : {0.5, 0.25, 0.1}) {
    const Mesh coarse = decimated(mesh, kept);
    const double all = static_cast<double>(mesh.triangles.size());
    EXPECT_NEAR(static_cast<double>(coarse.triangles.size()) / all, kept, 0.02);
    const double off_m = farthest_m(coarse, surface);
    EXPECT_GT(off_m, before_m) << "the coarser, the farther off";
    EXPECT_LT(off_m, 0.5) << "of a target 47 m long";
    before_m = off_m;
  }
}

TEST(Decimation, EveryPartKeepsItsPaintAndMostOfItsArea) {
  const Mesh mesh = build_boeing707();
  const Mesh coarse = decimated(mesh, 0.25);
  ASSERT_EQ(coarse.parts.size(), mesh.parts.size());
  const auto before = area_of_parts_m2(mesh);
  const auto after = area_of_parts_m2(coarse);
  for (size_t i = 0; i < mesh.parts.size(); ++i) {
    EXPECT_EQ(coarse.parts[i].name, mesh.parts[i].name);
    EXPECT_EQ(coarse.parts[i].albedo, mesh.parts[i].albedo);
  }
  for (const char* large : {"wing_port_outer", "wing_starboard_inner", "fin", "fuselage_upper"}) {
    EXPECT_NEAR(after.at(large) / before.at(large), 1, 0.1) << large;
  }
}

TEST(Decimation, NormalsAreUnitAndPointOutwards) {
  const Mesh coarse = decimated(build_boeing707(), 0.25);
  for (const Triangle& triangle : coarse.triangles) {
    for (const Eigen::Vector3d& normal : triangle.normal) {
      EXPECT_NEAR(normal.norm(), 1, 1e-9);
      EXPECT_GT(normal.dot(face_normal(coarse, triangle)), 0);
    }
  }
}

TEST(Decimation, AllOfATargetIsTheTargetItselfAndLessIsAnother) {
  const auto target = load_target("boeing707");
  EXPECT_EQ(decimated(target, 1), target);
  const auto coarse = decimated(target, 0.25);
  EXPECT_LT(coarse->mesh.triangles.size(), target->mesh.triangles.size() / 3);
  EXPECT_EQ(coarse->features.size(), target->features.size());
  EXPECT_EQ(coarse->shapes.size(), target->shapes.size());
}

// Two triangles back to back beside one that shares an edge with both: no surface.
TEST(Decimation, ASoupThatIsNoSurfaceIsTaken) {
  Mesh soup = build_cube().mesh;
  const int tip = static_cast<int>(soup.vertices.size());
  soup.vertices.emplace_back(2, 0, 0);
  const auto [a, b, c] = soup.triangles.front().vertex;
  soup.triangles.push_back({.vertex = {a, b, tip}, .part = 0});
  const Mesh coarse = decimated(soup, 0.9);
  EXPECT_GT(coarse.triangles.size(), 8u);
  EXPECT_LE(coarse.triangles.size(), soup.triangles.size());
}

}  // namespace
}  // namespace sightline
