// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <vector>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pose/attitude.h"
#include "pose/bounds.h"
#include "pose/solver.h"
#include "tests/pose/matchers.h"
#include "tests/pose/solvers/solving.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

using testing::IsEmpty;

TEST(Lspe, SitsOnItsBound) {
  constexpr int kTrials = 4000;
  constexpr double kSampling = 0.04;
  Draw draw(19);
  double geodesic2 = 0, translation2 = 0, bound2 = 0, normalised2 = 0;
  for (int i = 0; i < kTrials; ++i) {
    const Synthetic s = cube_problem(1, draw);
    const PoseEstimate estimate = solve("lspe", s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    const PoseBound bound =
        *cramer_rao_bound(s.problem.camera, s.problem.points_in_target, s.cam_from_target, 1);
    Vector6d delta;
    delta << vector_from_rotation(estimate.cam_from_target.rotation *
                                  s.cam_from_target.rotation.transpose()),
        estimate.cam_from_target.translation - s.cam_from_target.translation;
    geodesic2 += delta.head<3>().squaredNorm() / kTrials;
    translation2 += std::pow(translation_error_fraction(estimate.cam_from_target.translation,
                                                        s.cam_from_target.translation),
                             2) /
                    kTrials;
    bound2 += bound.geodesic_rms_rad * bound.geodesic_rms_rad / kTrials;
    normalised2 += delta.dot(estimate.unit_covariance.inverse() * delta) / kTrials;
  }
  EXPECT_NEAR(std::sqrt(geodesic2 / bound2), 1, kSampling);
  EXPECT_NEAR(std::sqrt(geodesic2) / kDegree, 0.445, kSampling * 0.445);
  EXPECT_NEAR(std::sqrt(translation2), 0.0020, kSampling * 0.0020);
  // The covariance is that of the errors: the chi-square of six degrees has the mean six.
  EXPECT_NEAR(normalised2, 6, kSampling * 6);
}

TEST(Lspe, IsStationaryAndMinimal) {
  Draw draw(20);
  for (int i = 0; i < 50; ++i) {
    const Synthetic s = cube_problem(2, draw);
    const PoseEstimate estimate = solve("lspe", s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    const double cost = sum_of_squares_px2(s.problem, estimate.cam_from_target);
    for (int k = 0; k < 50; ++k) {
      const double size = std::pow(10, draw.uniform(-6, -1));
      Vector6d delta;
      delta << size * draw.vector(),
          size * estimate.cam_from_target.translation.norm() * draw.vector();
      EXPECT_GE(sum_of_squares_px2(s.problem, retract(estimate.cam_from_target, delta)), cost);
    }
  }
}

/// Eight random points, some of them nearly in a plane, at 4 to 20 times their extent
/// through a wide lens or at 25 times that through a narrow one.
Synthetic cloud_problem(Draw& draw) {
  const std::vector<Eigen::Vector3d> points = points_in_box(8, {1, 1, 1}, draw);
  const double narrowness = draw.index(2) ? 25 : 1;
  const double range = narrowness * draw.uniform(4, 20);
  Synthetic s = exact_problem(centred_camera(640, 480, narrowness * 600), points,
                              {draw.rotation(), range * Eigen::Vector3d(0.1, -0.05, 1)});
  add_noise(s.problem, draw.uniform(0, 2), draw);
  return s;
}

TEST(Lspe, ConvergesFromStartsWithin120Degrees) {
  constexpr int kTrials = 100'000;
  Draw draw(21);
  int reached = 0;
  for (int i = 0; i < kTrials; ++i) {
    Synthetic s = i % 2 ? cube_problem(draw.uniform(0, 4), draw) : cloud_problem(draw);
    s.problem.initial_cam_from_target = s.cam_from_target;
    const Pose minimum = solve("lspe", s.problem).cam_from_target;
    s.problem.initial_cam_from_target = {
        draw.rotation_by(draw.uniform(0, 120) * kDegree) * s.cam_from_target.rotation,
        draw.uniform(0.7, 1.4) * s.cam_from_target.translation};
    const PoseEstimate estimate = solve("lspe", s.problem);
    reached += estimate.status == PoseStatus::kOk &&
               geodesic_angle_rad(estimate.cam_from_target.rotation, minimum.rotation) < 1e-7;
  }
  EXPECT_GE(reached, 0.999 * kTrials);
  RecordProperty("reached", reached);
}

TEST(Lspe, FindsTheMinimumWithoutAnyStart) {
  constexpr int kTrials = 100'000;
  Draw draw(37);
  int reached = 0;
  for (int i = 0; i < kTrials; ++i) {
    Synthetic s = i % 2 ? cube_problem(draw.uniform(0, 4), draw) : cloud_problem(draw);
    const PoseEstimate free = solve("lspe", s.problem);
    s.problem.initial_cam_from_target = s.cam_from_target;
    const Pose minimum = solve("lspe", s.problem).cam_from_target;
    reached += free.status == PoseStatus::kOk &&
               geodesic_angle_rad(free.cam_from_target.rotation, minimum.rotation) < 1e-7;
  }
  EXPECT_GE(reached, 0.9999 * kTrials);
}

TEST(Lspe, BothMirrorStartsOfAPlaneAreCarriedToTheEnd) {
  constexpr int kTrials = 200;
  Draw draw(22);
  for (int i = 0; i < kTrials; ++i) {
    Synthetic s = exact_problem(centred_camera(512, 512, 3000),
                                {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}},
                                {draw.rotation(), {0, 0, 30}});
    add_noise(s.problem, 0.5, draw);
    const PoseEstimate free = solve("lspe", s.problem);
    s.problem.initial_cam_from_target = s.cam_from_target;
    const PoseEstimate near_truth = solve("lspe", s.problem);
    ASSERT_EQ(free.status, PoseStatus::kOk);
    if (near_truth.status != PoseStatus::kOk) continue;
    EXPECT_LE(sum_of_squares_px2(s.problem, free.cam_from_target),
              sum_of_squares_px2(s.problem, near_truth.cam_from_target) * (1 + 1e-6));
  }
}

TEST(Lspe, StopsAtItsIterationLimitAndSaysSo) {
  Draw draw(23);
  Synthetic s = cube_problem(1, draw);
  s.problem.initial_cam_from_target = {draw.rotation_by(1) * s.cam_from_target.rotation,
                                       s.cam_from_target.translation};
  SolverOptions options;
  options.lspe.max_iterations = 2;
  const PoseEstimate stopped = solve("lspe", s.problem, options);
  EXPECT_EQ(stopped.status, PoseStatus::kDiverged);
  EXPECT_EQ(stopped.iterations, 4) << "two from the initial pose, two from the start without it";
  EXPECT_EQ(solve("lspe", s.problem).status, PoseStatus::kOk);
}

TEST(Lspe, RemovesNothingHoweverBadThePoint) {
  Draw draw(24);
  Synthetic s = cube_problem(0.3, draw);
  add_outlier(s.problem, 3, 30, draw);
  EXPECT_THAT(solve("lspe", s.problem).removed, IsEmpty());
}

}  // namespace
}  // namespace sightline
