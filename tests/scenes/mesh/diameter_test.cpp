// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/mesh/diameter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

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

// Points of many shapes, most of which have more long pairs than one would like.
Eigen::Vector3d point_of(int shape, RandomStream& stream) {
  const Eigen::Vector3d direction = stream.normal3().normalized();
  const double turn = stream.uniform(0, 2 * std::numbers::pi);
  const Eigen::Vector3d on_circle(std::cos(turn), std::sin(turn), 0);
  const double side = stream.uniform() < 0.5 ? -1 : 1;
  switch (shape) {
    case 0:
      return stream.normal3();
    case 1:
      return direction;
    case 2:
      return direction.cwiseProduct(Eigen::Vector3d(1, 0.99, 0.6));  // an ellipsoid
    case 3:
      return on_circle;  // coplanar
    case 4:
      return on_circle + Eigen::Vector3d(0, 0, side);  // a cylinder
    case 5:
      return direction + Eigen::Vector3d(0, 0, direction.z() > 0 ? 0.1 : 0);  // a capsule
    case 6:
      return Eigen::Vector3d(1, -2, 0.5) * stream.uniform();  // collinear
    case 7:
      return 1e-3 * stream.normal3() + Eigen::Vector3d(side, 0, 0);  // two far clusters
    case 8:
      return (2 * direction).array().round();  // many of the same
    case 9:
      return side > 0 ? on_circle : Eigen::Vector3d(0, 0, 3);  // a cone
    case 10:
      return 1e-9 * stream.normal3() + Eigen::Vector3d(side, 0, 0);  // two farther clusters
    default:
      return Eigen::Vector3d(side, side, side);  // two places
  }
}
constexpr int kShapes = 12;

TEST(Diameter, IsThatOfAllPairs) {
  constexpr int kClouds = 12 * kShapes;
  for (int cloud = 0; cloud < kClouds; ++cloud) {
    RandomStream stream(1, "cloud", cloud);
    const Eigen::Matrix3d turned = stream.rotation();
    const double size = std::pow(10, stream.uniform(-6, 6));
    const double distance = size * (cloud % 2 == 0 ? 0 : std::pow(10, stream.uniform(-1, 5)));
    const Eigen::Vector3d offset = distance * stream.normal3();
    const bool is_single = cloud % 3 > 0;  // as mesh files have them
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 600; ++i) {
      Eigen::Vector3d p = turned * point_of(cloud % kShapes, stream) * size + offset;
      if (is_single) p = p.cast<float>().cast<double>();
      points.push_back(p);
    }
    const double exact = by_all_pairs(points);
    EXPECT_EQ(diameter(points), exact) << cloud;
    const double hasty = diameter(points, 0);
    EXPECT_LE(hasty, exact) << cloud;
    EXPECT_GE(hasty, exact * (1 - 1e-13)) << cloud;
  }
}

// Rounded points that lie opposite each other: all diameters are the longest but for the rounding.
TEST(Diameter, OfABallOfRingsIsThatOfAllPairs) {
  for (int rings = 5; rings < 30; ++rings) {
    RandomStream stream(1, "rings", rings);
    const Eigen::Matrix3d turned = rings % 2 == 0 ? Eigen::Matrix3d::Identity() : stream.rotation();
    const Eigen::Vector3d offset = rings % 3 * stream.normal3();
    std::vector<Eigen::Vector3d> points;
    for (int ring = 0; ring <= rings; ++ring) {
      for (int column = 0; column < 2 * rings; ++column) {
        const double polar = std::numbers::pi * ring / rings;
        const double turn = std::numbers::pi * column / rings;
        const Eigen::Vector3d p(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn),
                                std::cos(polar));
        points.push_back((turned * p + offset).cast<float>().cast<double>());
      }
    }
    EXPECT_EQ(diameter(points), by_all_pairs(points)) << rings;
  }
}

// Points along the ends of chords whose lengths differ in the tenth digit: the longest is found
// although the bounds of the others' ends are only just below it.
TEST(Diameter, OfNearlyEqualChordsIsThatOfAllPairs) {
  for (int bundle = 0; bundle < 20; ++bundle) {
    RandomStream stream(1, "bundle", bundle);
    std::vector<Eigen::Vector3d> points;
    for (int chord = 0; chord < 8; ++chord) {
      const Eigen::Vector3d middle = 0.01 * stream.normal3();
      const Eigen::Vector3d half = stream.normal3().normalized() * stream.uniform(1 - 1e-10, 1);
      for (const double end : {-1, 1}) {
        points.emplace_back(middle + end * half);
        for (int i = 0; i < 40; ++i) {
          points.emplace_back(middle + end * stream.uniform(0.9, 1) * half);
        }
      }
    }
    EXPECT_EQ(diameter(points), by_all_pairs(points)) << bundle;
  }
}

// From the first point, and from the one that is farthest from the middle, the way to the farthest
// leads to the chord along x only; that along z is longer in the twelfth digit.
TEST(Diameter, OfALongerChordIsFoundWithoutPairsToSpare) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 1000; ++i) {
    const double inwards = 1 - 5e-6 * i;
    for (const double side : {1, -1}) {
      points.emplace_back(side * inwards, 0, 0);
      points.emplace_back(0, 0, side * inwards * (1 + 1e-12));
    }
    points.emplace_back(-0.01, 1.01 * inwards, 0);
  }
  EXPECT_EQ(diameter(points, 0), 2 * (1 + 1e-12));
}

// Two squares that face each other: what the distances differ by is less than their rounding.
std::vector<Eigen::Vector3d> facing_squares(const Eigen::Matrix3d& turned, int points_of_one) {
  RandomStream stream(1, "squares", points_of_one);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 2 * points_of_one; ++i) {
    const double y = stream.uniform(-1e-5, 1e-5);
    points.push_back(turned * Eigen::Vector3d(i % 2 * 1000, y, stream.uniform(-1e-5, 1e-5)));
  }
  return points;
}

TEST(Diameter, OfSquaresThatFaceEachOtherIsThatOfAllPairs) {
  const Eigen::Matrix3d turned = RandomStream(1, "turn", 0).rotation();
  for (const Eigen::Matrix3d& turn : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), turned}) {
    const auto points = facing_squares(turn, 500);
    EXPECT_EQ(diameter(points), by_all_pairs(points));
  }
}

// Comparing all pairs would take minutes: bounds spare the first that, the most pairs the second.
TEST(Diameter, ManyPointsOnSquaresThatFaceEachOtherAreNoMatter) {
  constexpr int kMany = 300'000;
  const Eigen::Matrix3d turned = RandomStream(1, "turn", 0).rotation();
  EXPECT_NEAR(diameter(facing_squares(Eigen::Matrix3d::Identity(), kMany)), 1000, 1e-12);
  EXPECT_NEAR(diameter(facing_squares(turned, kMany), 1'000'000), 1000, 1e-12);
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
