// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/bounds.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "pose/attitude.h"
#include "pose/reprojection.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

PoseBound bound_of(const Synthetic& s, double sigma_px) {
  return cramer_rao_bound(s.problem.camera, s.problem.points_in_target, s.cam_from_target, sigma_px)
      .value();
}

// FACTS: 8 points of the cube, 1 px, 50..150 m: geodesic 0.445 deg, T_error 0.20 %.
TEST(CramerRaoBound, OfTheCubeSetting) {
  constexpr int kPoses = 4000;
  constexpr double kSampling = 0.03;  // of the mean over this many poses
  Draw draw(1);
  double geodesic2 = 0;
  double translation2 = 0;
  for (int i = 0; i < kPoses; ++i) {
    const PoseBound bound = bound_of(cube_problem(0, draw), 1);
    geodesic2 += bound.geodesic_rms_rad * bound.geodesic_rms_rad / kPoses;
    translation2 += bound.translation_rms * bound.translation_rms / kPoses;
  }
  EXPECT_NEAR(std::sqrt(geodesic2) / kDegree, 0.445, kSampling * 0.445);
  EXPECT_NEAR(std::sqrt(translation2), 0.0020, kSampling * 0.0020);
}

// A single-axis closed form: points on a circle of radius r about the axis of view at range z. A
// roll moves each by f r / z, and nothing else looks like a roll: sd = sigma z / (f r sqrt(n)).
TEST(CramerRaoBound, RollOfARingSeenAlongItsAxis) {
  constexpr int kPoints = 12;
  constexpr double kRadius = 0.5, kRange = 80, kFocal = 10000, kSigma = 0.7;
  std::vector<Eigen::Vector3d> ring;
  for (int i = 0; i < kPoints; ++i) {
    const double phase = 2 * kPi * i / kPoints;
    ring.emplace_back(kRadius * std::cos(phase), kRadius * std::sin(phase), 0);
  }
  const auto bound = cramer_rao_bound(centred_camera(512, 512, kFocal), ring,
                                      {Eigen::Matrix3d::Identity(), {0, 0, kRange}}, kSigma);
  ASSERT_TRUE(bound);
  const double expected = kSigma * kRange / (kFocal * kRadius * std::sqrt(double{kPoints}));
  EXPECT_NEAR(std::sqrt(bound->covariance(2, 2)), expected, 1e-9 * expected);
}

TEST(CramerRaoBound, IsProportionalToTheNoise) {
  Draw draw(2);
  const Synthetic s = cube_problem(0, draw);
  const PoseBound one = bound_of(s, 1);
  const PoseBound three = bound_of(s, 3);
  EXPECT_NEAR(three.geodesic_rms_rad, 3 * one.geodesic_rms_rad, 1e-12 * one.geodesic_rms_rad);
  EXPECT_NEAR(three.attitude_rms_rad, 3 * one.attitude_rms_rad, 1e-12 * one.attitude_rms_rad);
  EXPECT_NEAR(three.translation_rms, 3 * one.translation_rms, 1e-12 * one.translation_rms);
  EXPECT_FALSE(
      cramer_rao_bound(s.problem.camera, s.problem.points_in_target, s.cam_from_target, 0.0));
}

/// The information of (w, dt) in the target's own frame, by differences of the pixels.
Matrix6d numeric_covariance(const Synthetic& s) {
  constexpr double kStep = 1e-5;
  Matrix6d information = Matrix6d::Zero();
  for (const Eigen::Vector3d& x : s.problem.points_in_target) {
    const auto pixel = [&](const Vector6d& delta) {
      return project(s.problem.camera, retract(s.cam_from_target, delta) * x).value();
    };
    Eigen::Matrix<double, 2, 6> jacobian;
    for (int k = 0; k < 6; ++k) {
      const Vector6d h = kStep * Vector6d::Unit(k);
      jacobian.col(k) = (pixel(h) - pixel(-h)) / (2 * kStep);
    }
    information += jacobian.transpose() * jacobian;
  }
  return information.inverse();
}

TEST(CramerRaoBound, IsTheInverseOfTheInformationInTheTargetFrame) {
  Draw draw(9);
  for (int i = 0; i < 20; ++i) {
    std::vector<Eigen::Vector3d> points;
    for (int k = 0; k < 8; ++k) points.push_back(draw.in_box(1) + Eigen::Vector3d(2, -1, 0.5));
    Camera camera = centred_camera(640, 480, 500);
    camera.fy_px = 600;
    std::get<BrownConrady>(camera.lens).k1 = -0.1;
    const Synthetic s = exact_problem(camera, points, {draw.rotation(), {0.5, 0.3, 8}});
    const Matrix6d expected = numeric_covariance(s);
    EXPECT_TRUE(is_matrix_near(bound_of(s, 1).covariance, expected, 1e-5 * expected.norm()));
  }
}

TEST(CramerRaoBound, FollowsTheTargetFrame) {
  // The covariance is that of the named frame: with an origin 20 m off, translation is known worse,
  // rotation as before.
  Draw draw(3);
  const Synthetic s = cube_problem(0, draw);
  const Pose shifted_from_target = {draw.rotation(), {20, 0, 0}};
  std::vector<Eigen::Vector3d> shifted;
  for (const auto& x : s.problem.points_in_target) shifted.push_back(shifted_from_target * x);
  const PoseBound near = bound_of(s, 1);
  const PoseBound far = cramer_rao_bound(s.problem.camera, shifted,
                                         s.cam_from_target * inverse(shifted_from_target), 1)
                            .value();
  EXPECT_NEAR(far.geodesic_rms_rad, near.geodesic_rms_rad, 1e-8 * near.geodesic_rms_rad);
  const double far_trace = far.covariance.bottomRightCorner<3, 3>().trace();
  EXPECT_GT(far_trace, (near.covariance.bottomRightCorner<3, 3>().trace()));
}

TEST(CramerRaoBound, AttitudeFollowsTheDerivativeOfTheAngles) {
  constexpr double kStep = 1e-6;
  Draw draw(4);
  for (int i = 0; i < 20; ++i) {
    Synthetic s = cube_problem(0, draw);
    s.cam_from_target.rotation =
        rotation_from_attitude({draw.uniform(-3, 3), draw.uniform(-1.2, 1.2), draw.uniform(-3, 3)});
    const PoseBound bound = bound_of(s, 1);
    Eigen::Matrix3d angles_from_w;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d h = kStep * Eigen::Vector3d::Unit(k);
      const Attitude plus =
          attitude_from_rotation(rotation_from_vector(h) * s.cam_from_target.rotation);
      const Attitude minus =
          attitude_from_rotation(rotation_from_vector(-h) * s.cam_from_target.rotation);
      angles_from_w.col(k) << std::remainder(plus.pitch_rad - minus.pitch_rad, 2 * kPi),
          plus.yaw_rad - minus.yaw_rad, std::remainder(plus.roll_rad - minus.roll_rad, 2 * kPi);
    }
    angles_from_w /= 2 * kStep;
    const double expected = std::sqrt(
        (angles_from_w * bound.covariance.topLeftCorner<3, 3>() * angles_from_w.transpose())
            .trace() /
        3);
    EXPECT_NEAR(bound.attitude_rms_rad, expected, 1e-6 * expected);
  }
}

TEST(CramerRaoBound, AttitudeIsUnboundedInGimbalLock) {
  Draw draw(5);
  Synthetic s = cube_problem(0, draw);
  s.cam_from_target.rotation << 0, 0, 1, 0, 1, 0, -1, 0, 0;  // yaw = 90 deg
  const PoseBound bound = bound_of(s, 1);
  EXPECT_EQ(bound.attitude_rms_rad, kInfinity);
  EXPECT_LT(bound.geodesic_rms_rad, 0.1);
}

TEST(CramerRaoBound, CountsThePixelsOfTheLens) {
  // A lens that magnifies by 2 at the centre halves the bound of a small target there.
  Draw draw(6);
  Synthetic s = cube_problem(0, draw);
  s.cam_from_target.translation = {0, 0, 100};
  const double plain = bound_of(s, 1).geodesic_rms_rad;
  Camera doubled = s.problem.camera;
  doubled.fx_px *= 2;
  doubled.fy_px *= 2;
  EXPECT_NEAR(
      cramer_rao_bound(doubled, s.problem.points_in_target, s.cam_from_target, 1)->geodesic_rms_rad,
      plain / 2, 1e-9 * plain);
  // Off the axis, r2 = 0.25, k1 stretches by 1 + k1 r2 across and 1 + 3 k1 r2 along the radius.
  s.cam_from_target.translation = {50, 0, 100};
  std::get<BrownConrady>(s.problem.camera.lens).k1 = 0.4;
  const double lens = bound_of(s, 1).geodesic_rms_rad;
  std::get<BrownConrady>(s.problem.camera.lens).k1 = 0;
  const double no_lens = bound_of(s, 1).geodesic_rms_rad;
  EXPECT_GT(lens, no_lens / 1.3);
  EXPECT_LT(lens, no_lens / 1.1);
}

TEST(CramerRaoBound, NeedsPointsThatDetermineAPose) {
  Draw draw(7);
  const Synthetic s = cube_problem(0, draw);
  const auto bound = [&s](const std::vector<Eigen::Vector3d>& points) {
    return cramer_rao_bound(s.problem.camera, points, s.cam_from_target, 1);
  };
  EXPECT_TRUE(bound({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_FALSE(bound({}));
  EXPECT_FALSE(bound({{0, 0, 0}, {1, 0, 0}}));
  EXPECT_FALSE(bound({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3.5, 0, 0}}));
  EXPECT_FALSE(bound({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}));
  EXPECT_FALSE(bound({{0, 0, 0}, {1, 0, 0}, {0, 1, kNaN}}));
  EXPECT_FALSE(bound({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1e4}, {0, 0, -1e4}}));
}

TEST(CramerRaoBound, NeedsSoundInput) {
  Draw draw(8);
  const Synthetic s = cube_problem(0, draw);
  const auto& points = s.problem.points_in_target;
  EXPECT_FALSE(cramer_rao_bound(s.problem.camera, points, s.cam_from_target, -1));
  EXPECT_FALSE(cramer_rao_bound(s.problem.camera, points, s.cam_from_target, kNaN));
  Pose behind = s.cam_from_target;
  behind.translation.z() *= -1;
  EXPECT_FALSE(cramer_rao_bound(s.problem.camera, points, behind, 1));
  Pose broken = s.cam_from_target;
  broken.rotation(0, 0) = kNaN;
  EXPECT_FALSE(cramer_rao_bound(s.problem.camera, points, broken, 1));
}

TEST(Bound, WeighsEachPointByItsCovariance) {
  Draw draw(50);
  const Synthetic s = cube_problem(0, draw);
  const auto& points = s.problem.points_in_target;
  const auto bound = [&](const std::vector<Eigen::Matrix2d>& covariances_px2) {
    return cramer_rao_bound(s.problem.camera, points, s.cam_from_target, covariances_px2);
  };
  std::vector<Eigen::Matrix2d> covariances_px2(8, 4 * Eigen::Matrix2d::Identity());
  const auto uniform = cramer_rao_bound(s.problem.camera, points, s.cam_from_target, 2.0);
  EXPECT_TRUE(bound(covariances_px2)->covariance.isApprox(uniform->covariance, 1e-12));

  // A point with all but infinite noise is as good as absent.
  covariances_px2[3] *= 1e12;
  std::vector<Eigen::Vector3d> others = points;
  others.erase(others.begin() + 3);
  const auto without = cramer_rao_bound(s.problem.camera, others, s.cam_from_target, 2.0);
  EXPECT_TRUE(bound(covariances_px2)->covariance.isApprox(without->covariance, 1e-6));

  covariances_px2[3] << 1, 2, 2, 1;  // indefinite
  EXPECT_FALSE(bound(covariances_px2));
  covariances_px2.pop_back();
  EXPECT_FALSE(bound(covariances_px2));
}

}  // namespace
}  // namespace sightline
