// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/p3p.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

using Three = std::array<Eigen::Vector3d, 3>;

struct Sight {
  Three points_in_target;
  Three rays_in_cam;
  Pose cam_from_target;
};

Three rays_to(const Three& points_in_target, const Pose& cam_from_target) {
  Three rays;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d x_in_cam = cam_from_target * points_in_target[i];
    rays[i] = x_in_cam / x_in_cam.z();
  }
  return rays;
}

Sight random_sight(double half_width_m, const Eigen::Vector3d& centre_in_cam, Draw& draw) {
  Sight s;
  s.cam_from_target = {draw.rotation(), centre_in_cam};
  for (auto& x : s.points_in_target) x = draw.in_box(half_width_m);
  s.rays_in_cam = rays_to(s.points_in_target, s.cam_from_target);
  return s;
}

double largest_ray_error(const Sight& s, const Pose& pose) {
  const Three rays = rays_to(s.points_in_target, pose);
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    largest = std::max(largest, (rays[i] - s.rays_in_cam[i]).norm());
  }
  return largest;
}

/// In radians and in parts of the range.
double error_of(const Pose& pose, const Pose& truth) {
  return std::max(geodesic_angle_rad(pose.rotation, truth.rotation),
                  (pose.translation - truth.translation).norm() / truth.translation.norm());
}

struct Tally {
  int missed = 0;        ///< the truth is not among the solutions
  double worst_ray = 0;  ///< error of any solution, in units of the target's angular size
  std::size_t most = 0;  ///< solutions of one sight
  bool are_all_valid = true;
};

/// Rounding of rays (1e-16) is magnified near double roots to its square root, 1e-8.
constexpr double kTruth = 1e-7;

template <typename DrawSight>
Tally tally(int trials, double angular_size_rad, const DrawSight& draw_sight) {
  Tally t;
  for (int i = 0; i < trials; ++i) {
    const Sight s = draw_sight();
    const P3pPoses poses = p3p(s.points_in_target, s.rays_in_cam);
    double best = kInfinity;
    for (const Pose& pose : poses.all()) {
      best = std::min(best, error_of(pose, s.cam_from_target));
      t.worst_ray = std::max(t.worst_ray, largest_ray_error(s, pose) / angular_size_rad);
      t.are_all_valid = t.are_all_valid && is_valid(pose);
    }
    t.missed += !(best < kTruth);
    t.most = std::max(t.most, poses.count);
  }
  return t;
}

constexpr int kTrials = 100000;
constexpr int kMostMissed = kTrials / 10000;

TEST(P3p, FindsTheTruthOfRandomTriangles) {
  Draw draw(1);
  const Tally t = tally(kTrials, 0.3, [&draw] {
    return random_sight(1, {draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(3, 6)}, draw);
  });
  EXPECT_LE(t.missed, kMostMissed);
  EXPECT_TRUE(t.are_all_valid);
  EXPECT_LT(t.worst_ray, 1e-9);
  EXPECT_EQ(t.most, 4u);
}

// f = 15000 px: 1e-9 of the target's 150 px.
TEST(P3p, FindsTheTruthNearWeakPerspective) {
  Draw draw(2);
  const Tally t = tally(kTrials, 0.01, [&draw] {
    return random_sight(0.5, {draw.uniform(-0.3, 0.3), draw.uniform(-0.3, 0.3), 100}, draw);
  });
  EXPECT_LE(t.missed, kMostMissed);
  EXPECT_TRUE(t.are_all_valid);
  EXPECT_LT(t.worst_ray, 1e-9);
}

TEST(P3p, SymmetricTripodHasFourPoses) {
  // An equilateral triangle seen along its axis under right angles: besides the symmetric pose one
  // vertex may slide along its ray, in three ways (Fischler and Bolles 1981, figure 5).
  const double s = std::sqrt(3.0);
  Sight sight;
  sight.points_in_target = {{{2, 0, 0}, {-1, s, 0}, {-1, -s, 0}}};
  sight.cam_from_target.translation = {0, 0, 4};
  sight.rays_in_cam = rays_to(sight.points_in_target, sight.cam_from_target);
  const P3pPoses poses = p3p(sight.points_in_target, sight.rays_in_cam);
  ASSERT_EQ(poses.count, 4u);
  int symmetric = 0;
  for (const Pose& pose : poses.all()) {
    EXPECT_LT(largest_ray_error(sight, pose), 1e-12);
    symmetric += error_of(pose, sight.cam_from_target) < 1e-9;
  }
  EXPECT_EQ(symmetric, 1);
}

TEST(P3p, LengthOfRaysUnitAndOrderDoNotMatter) {
  Draw draw(3);
  for (int i = 0; i < 200; ++i) {
    const Sight s = random_sight(1, {0, 0, 5}, draw);
    Three points = s.points_in_target;
    Three rays = s.rays_in_cam;
    for (auto& x : points) x *= 1e6;
    for (auto& ray : rays) ray *= draw.uniform(0.1, 100);
    std::rotate(points.begin(), points.begin() + 1, points.end());
    std::rotate(rays.begin(), rays.begin() + 1, rays.end());
    double best = kInfinity;
    const P3pPoses poses = p3p(points, rays);
    for (Pose pose : poses.all()) {
      pose.translation /= 1e6;
      best = std::min(best, error_of(pose, s.cam_from_target));
    }
    EXPECT_LT(best, kTruth);
  }
}

TEST(P3p, DegenerateTrianglesHaveNoPose) {
  Draw draw(4);
  for (int i = 0; i < 100; ++i) {
    const Sight good = random_sight(1, {0, 0, 5}, draw);
    ASSERT_GT(p3p(good.points_in_target, good.rays_in_cam).count, 0u);
    for (const double bad : {kNaN, kInfinity}) {
      Sight s = good;
      s.points_in_target[1].y() = bad;
      EXPECT_EQ(p3p(s.points_in_target, s.rays_in_cam).count, 0u);
      s = good;
      s.rays_in_cam[2].x() = bad;
      EXPECT_EQ(p3p(s.points_in_target, s.rays_in_cam).count, 0u);
    }
    Three line = good.points_in_target;
    line[2] = line[0] + 0.3 * (line[1] - line[0]);
    EXPECT_EQ(p3p(line, good.rays_in_cam).count, 0u);
    Three spot = good.points_in_target;
    spot[1] = spot[0];
    EXPECT_EQ(p3p(spot, good.rays_in_cam).count, 0u);
    Three two_rays = good.rays_in_cam;
    two_rays[1] = two_rays[2];
    EXPECT_EQ(p3p(good.points_in_target, two_rays).count, 0u);
    for (const double z : {0.0, -1.0}) {
      Three backward = good.rays_in_cam;
      backward[0] = {0, 0, z};
      EXPECT_EQ(p3p(good.points_in_target, backward).count, 0u);
    }
  }
}

// What is not a picture of the triangle has no pose, or poses that show it all the same.
TEST(P3p, RandomRaysAreMetOrHaveNoPose) {
  Draw draw(5);
  int without_pose = 0;
  for (int i = 0; i < 10000; ++i) {
    Sight s = random_sight(1, {0, 0, 5}, draw);
    for (auto& ray : s.rays_in_cam) ray = {draw.uniform(-1, 1), draw.uniform(-1, 1), 1};
    const P3pPoses poses = p3p(s.points_in_target, s.rays_in_cam);
    without_pose += poses.count == 0;
    for (const Pose& pose : poses.all()) {
      EXPECT_TRUE(is_valid(pose));
      EXPECT_LT(largest_ray_error(s, pose), 1e-6);
    }
  }
  EXPECT_GT(without_pose, 0);
}

}  // namespace
}  // namespace sightline
