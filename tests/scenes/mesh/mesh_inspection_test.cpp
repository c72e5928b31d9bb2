// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/mesh_inspection.h"

#include <utility>

#include <gtest/gtest.h>

#include "scenes/builders/cube.h"

namespace sightline {
namespace {

TEST(MeshInspection, KnowsACube) {
  const MeshInspection cube = inspect(build_cube().mesh);
  EXPECT_EQ(cube.vertices, 8);
  EXPECT_EQ(cube.triangles, 12);
  EXPECT_EQ(cube.components, 1);
  EXPECT_EQ(cube.closed_components, 1);
  EXPECT_EQ(cube.open_edges, 0);
  EXPECT_EQ(cube.flipped_edges, 0);
  EXPECT_EQ(cube.inward_components, 0);
  EXPECT_EQ(cube.sharp_edges, 12);
  EXPECT_NEAR(cube.sharp_length_m, 12, 1e-12);
  EXPECT_NEAR(cube.volume_m3, 1, 1e-12);
  for (const auto& part : cube.parts) EXPECT_NEAR(part.area_m2, 1, 1e-12) << part.name;
}

TEST(MeshInspection, SeesAHole) {
  Mesh mesh = build_cube().mesh;
  mesh.triangles.pop_back();
  const MeshInspection cube = inspect(mesh);
  EXPECT_EQ(cube.open_edges, 3);
  EXPECT_EQ(cube.closed_components, 0);
}

TEST(MeshInspection, SeesAFlippedFaceAndAnInsideOutPiece) {
  Mesh one = build_cube().mesh;
  std::swap(one.triangles[0].vertex[0], one.triangles[0].vertex[1]);
  EXPECT_EQ(inspect(one).flipped_edges, 3);
  Mesh all = build_cube().mesh;
  for (Triangle& triangle : all.triangles) std::swap(triangle.vertex[0], triangle.vertex[1]);
  EXPECT_EQ(inspect(all).flipped_edges, 0);
  EXPECT_EQ(inspect(all).inward_components, 1);
  EXPECT_EQ(inspect(all).sharp_edges, 12);
}

TEST(MeshInspection, CountsPieces) {
  Mesh two = build_cube().mesh;
  const Mesh other = build_cube().mesh;
  const int offset = static_cast<int>(two.vertices.size());
  for (const Eigen::Vector3d& v : other.vertices) {
    two.vertices.push_back(v + Eigen::Vector3d(5, 0, 0));
  }
  for (Triangle triangle : other.triangles) {
    for (int& v : triangle.vertex) v += offset;
    two.triangles.push_back(triangle);
  }
  EXPECT_EQ(inspect(two).components, 2);
  EXPECT_NEAR(inspect(two).volume_m3, 2, 1e-12);
}

}  // namespace
}  // namespace sightline
