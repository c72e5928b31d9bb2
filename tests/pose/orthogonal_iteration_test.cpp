// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/orthogonal_iteration.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

/// The error that orthogonal iteration minimises.
double object_space_error_m2(const PoseProblem& problem, const Pose& cam_from_target) {
  double sum = 0;
  for (std::size_t i = 0; i < problem.pixels.size(); ++i) {
    const Eigen::Vector3d b = bearing(problem.camera, problem.pixels[i]).value();
    const Eigen::Vector3d x = cam_from_target * problem.points_in_target[i];
    sum += (x - b * b.dot(x)).squaredNorm();
  }
  return sum;
}

bool is_in_front(const PoseProblem& problem, const Pose& cam_from_target) {
  for (const Eigen::Vector3d& x : problem.points_in_target) {
    if (!((cam_from_target * x).z() > 0)) return false;
  }
  return true;
}

/// A wide view of a solid target from near by, with a lens and fx != fy.
Synthetic near_problem(Draw& draw, double thickness = 1) {
  Camera camera = centred_camera(640, 480, 400);
  camera.fy_px = 420;
  camera.lens = BrownConrady{.k1 = -0.1, .k2 = 0.02, .p1 = 1e-3, .p2 = -1e-3, .k3 = 0};
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 10; ++i) {
    points.push_back(Eigen::Vector3d(1, 1, thickness).cwiseProduct(draw.in_box(1)));
  }
  return exact_problem(camera, points, {draw.rotation(), {0.3, -0.2, 4}});
}

TEST(OrthogonalIteration, FindsTheExactPoseInAWideView) {
  Draw draw(1);
  for (int i = 0; i < 50; ++i) {
    const Synthetic s = near_problem(draw);
    const std::vector<Pose> starts = orthogonal_iteration_starts(
        s.problem, {.max_iterations = 5000, .relative_tolerance = 1e-12});
    ASSERT_FALSE(starts.empty());
    EXPECT_TRUE(is_pose_near(starts[0], s.cam_from_target, 1e-5, 1e-4));
  }
}

TEST(OrthogonalIteration, StartsNearEnoughAtLongRange) {
  Draw draw(2);
  for (int i = 0; i < 200; ++i) {
    const Synthetic s = cube_problem(1, draw);
    const std::vector<Pose> starts = orthogonal_iteration_starts(s.problem);
    ASSERT_EQ(starts.size(), 1u);
    EXPECT_TRUE(is_pose_near(starts[0], s.cam_from_target, 10 * kDegree,
                             0.05 * s.cam_from_target.translation.norm()));
  }
}

TEST(OrthogonalIteration, LowersItsErrorAndStops) {
  Draw draw(3);
  for (int i = 0; i < 20; ++i) {
    Synthetic s = near_problem(draw);
    add_noise(s.problem, 1, draw);
    double before = kInfinity;
    for (const int n : {0, 1, 2, 5, 20, 100}) {
      const std::vector<Pose> starts =
          orthogonal_iteration_starts(s.problem, {.max_iterations = n, .relative_tolerance = 0});
      if (starts.empty()) continue;  // the affine start itself may lie behind the camera
      const double error = object_space_error_m2(s.problem, starts[0]);
      EXPECT_LE(error, before * (1 + 1e-12));
      before = error;
    }
    EXPECT_LT(before, kInfinity);
  }
}

TEST(OrthogonalIteration, PlanarTargetsHaveTwoMirrorStarts) {
  Draw draw(4);
  int near_truth = 0;
  constexpr int kTrials = 100;
  for (int i = 0; i < kTrials; ++i) {
    std::vector<Eigen::Vector3d> square = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0.02}, {-1, 1, 0}};
    const Eigen::Matrix3d tilt = rotation_from_vector({0.7, 0.3, 0.2});
    const Synthetic s = exact_problem(centred_camera(512, 512, 10000), square,
                                      {draw.rotation_by(0.2) * tilt, {0, 0, 100}});
    const std::vector<Pose> starts = orthogonal_iteration_starts(s.problem);
    ASSERT_EQ(starts.size(), 2u);
    EXPECT_GT(geodesic_angle_rad(starts[0].rotation, starts[1].rotation), 20 * kDegree);
    EXPECT_LE(object_space_error_m2(s.problem, starts[0]),
              object_space_error_m2(s.problem, starts[1]));
    for (const Pose& start : starts) {
      near_truth += geodesic_angle_rad(start.rotation, s.cam_from_target.rotation) < 0.05;
    }
  }
  EXPECT_EQ(near_truth, kTrials);
}

TEST(OrthogonalIteration, PlanesSeenEdgeOnHaveStarts) {
  const std::vector<Eigen::Vector3d> square = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  const Synthetic s = exact_problem(centred_camera(512, 512, 2000), square,
                                    {rotation_from_vector({kPi / 2, 0, 0}), {0, 0, 20}});
  EXPECT_FALSE(orthogonal_iteration_starts(s.problem).empty());
}

TEST(OrthogonalIteration, StartsAreInFrontOfTheCamera) {
  Draw draw(5);
  for (int i = 0; i < 200; ++i) {
    Synthetic s = near_problem(draw, i % 2);
    // Pixels that have nothing to do with the points.
    for (Eigen::Vector2d& pixel : s.problem.pixels) {
      pixel = {draw.uniform(0, 639), draw.uniform(0, 479)};
    }
    for (const Pose& start : orthogonal_iteration_starts(s.problem)) {
      EXPECT_TRUE(is_valid(start));
      EXPECT_TRUE(is_in_front(s.problem, start));
    }
  }
}

TEST(OrthogonalIteration, HasNoStartForDegenerateInput) {
  Draw draw(6);
  const Synthetic good = near_problem(draw);
  EXPECT_FALSE(orthogonal_iteration_starts(good.problem).empty());
  EXPECT_TRUE(orthogonal_iteration_starts({}).empty());

  PoseProblem three = good.problem;
  three.points_in_target.resize(3);
  three.pixels.resize(3);
  EXPECT_TRUE(orthogonal_iteration_starts(three).empty());

  PoseProblem uneven = good.problem;
  uneven.pixels.pop_back();
  EXPECT_TRUE(orthogonal_iteration_starts(uneven).empty());

  PoseProblem line = good.problem;
  for (auto& x : line.points_in_target) x = x.x() * Eigen::Vector3d(1, 2, 3);
  EXPECT_TRUE(orthogonal_iteration_starts(line).empty());

  PoseProblem spot = good.problem;
  for (auto& x : spot.points_in_target) x = {1, 2, 3};
  EXPECT_TRUE(orthogonal_iteration_starts(spot).empty());

  PoseProblem one_pixel = good.problem;
  for (auto& u : one_pixel.pixels) u = {100, 100};
  EXPECT_TRUE(orthogonal_iteration_starts(one_pixel).empty());

  for (const double bad : {kNaN, kInfinity}) {
    PoseProblem broken = good.problem;
    broken.pixels[3].x() = bad;
    EXPECT_TRUE(orthogonal_iteration_starts(broken).empty());
    broken = good.problem;
    broken.points_in_target[3].x() = bad;
    EXPECT_TRUE(orthogonal_iteration_starts(broken).empty());
  }
}

}  // namespace
}  // namespace sightline
