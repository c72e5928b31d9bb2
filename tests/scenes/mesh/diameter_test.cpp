// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/diameter.h"

#include <cmath>

#include <gtest/gtest.h>

#include "scenes/random/random.h"

namespace sightline {
namespace {

double by_all_pairs(const std::vector<Eigen::Vector3d>& points) {
  double best = 0;
  for (const auto& p : points) {
    for (const auto& q : points) best = std::max(best, (p - q).norm());
  }
  return best;
}

TEST(Diameter, IsThatOfAllPairs) {
  for (int cloud = 0; cloud < 6; ++cloud) {
    RandomStream stream(1, "cloud", cloud);
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 700; ++i) {
      Eigen::Vector3d p = stream.normal3();
      if (cloud % 3 == 1) p.normalize();      // on a sphere, where nothing stands out
      if (cloud % 3 == 2) p.z() = p.y() = 0;  // on a line
      points.push_back(p + Eigen::Vector3d(cloud, 0, 0));
    }
    EXPECT_EQ(diameter(points), by_all_pairs(points)) << cloud;
  }
}

TEST(Diameter, OfFewPoints) {
  EXPECT_EQ(diameter({}), 0);
  EXPECT_EQ(diameter({{1, 2, 3}}), 0);
  EXPECT_EQ(diameter({{1, 2, 3}, {1, 2, 3}}), 0);
  EXPECT_EQ(diameter({{0, 0, 0}, {3, 4, 0}, {1, 1, 0}}), 5);
}

TEST(Diameter, ManyPointsOnASphereAreNoMatter) {
  std::vector<Eigen::Vector3d> points;
  RandomStream stream(1, "sphere", 0);
  for (int i = 0; i < 30000; ++i) points.push_back(stream.normal3().normalized());
  const double d = diameter(points);
  EXPECT_GT(d, 1.999);
  EXPECT_LE(d, 2 + 1e-15);
}

}  // namespace
}  // namespace sightline
