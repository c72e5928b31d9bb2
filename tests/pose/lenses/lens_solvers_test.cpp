// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Poses through every lens.
#include <cmath>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "pose/bounds.h"
#include "pose/solver.h"
#include "tests/pose/lenses/lenses_for_tests.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

std::vector<Eigen::Vector3d> cloud(int count, Draw& draw) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) points.push_back(draw.in_box(1));
  return points;
}

Pose wide_pose(Draw& draw) {
  Pose pose;
  pose.rotation = draw.rotation();
  pose.translation = {draw.uniform(-0.8, 0.8), draw.uniform(-0.6, 0.6), 2.5};
  return pose;
}

TEST(LensSolvers, EverySolverIsExactThroughEveryLens) {
  constexpr double kExact = 1e-8;  // of a pixel's rounding, some hundred times
  for (const auto& [name, camera] : cameras_with_lenses()) {
    for (const PoseSolver& solver : pose_solvers()) {
      Draw draw(1);
      for (int i = 0; i < 5; ++i) {
        const Synthetic s = exact_problem(camera, cloud(8, draw), wide_pose(draw));
        const PoseEstimate estimate = solver.solve(s.problem, {});
        ASSERT_EQ(estimate.status, PoseStatus::kOk) << solver.name << ", " << name;
        EXPECT_TRUE(is_pose_near(estimate.cam_from_target, s.cam_from_target, kExact, kExact))
            << solver.name << ", " << name;
      }
    }
  }
}

TEST(LensSolvers, ALensThatIsLeftOutIsNotExact) {
  Draw draw(2);
  for (const auto& [name, camera] : cameras_with_lenses()) {
    Synthetic s = exact_problem(camera, cloud(8, draw), wide_pose(draw));
    s.problem.camera.lens = {};
    s.problem.camera.skew_px = 0;
    const PoseEstimate estimate = find_pose_solver("lspe")->solve(s.problem, {});
    const bool is_ok = estimate.status == PoseStatus::kOk;
    EXPECT_FALSE(is_ok && is_pose_near(estimate.cam_from_target, s.cam_from_target, 1e-3, 1e-3))
        << name;
  }
}

// Root mean square angle of poses from points that a fisheye sees at up to some 70 degrees, over
// that of the bound, and the mean of the errors squared by the stated covariance.
struct Accuracy {
  double over_bound = 0;
  double chi2 = 0;
};

Accuracy accuracy(const char* solver, double stated_sigma_px) {
  constexpr double kSigmaPx = 0.5;
  constexpr int kTrials = 400;
  Camera camera = centred_camera(640, 480, 220);
  camera.lens = KannalaBrandt{.k1 = -0.02, .k2 = 0.005};
  Draw draw(5);
  double square = 0, bound = 0;
  Accuracy result;
  for (int i = 0; i < kTrials; ++i) {
    const Pose pose = {draw.rotation(), {draw.uniform(-2.2, 2.2), draw.uniform(-1, 1), 1.9}};
    Synthetic s = exact_problem(camera, cloud(16, draw), pose);
    add_noise(s.problem, kSigmaPx, draw);
    s.problem.sigma_px = stated_sigma_px;
    const PoseEstimate estimate = find_pose_solver(solver)->solve(s.problem, {});
    EXPECT_EQ(estimate.status, PoseStatus::kOk);
    const double angle = geodesic_angle_rad(estimate.cam_from_target.rotation, pose.rotation);
    square += angle * angle;
    const auto least = cramer_rao_bound(camera, s.problem.points_in_target, pose, kSigmaPx);
    bound += least->geodesic_rms_rad * least->geodesic_rms_rad;
    const Eigen::Vector3d w =
        vector_from_rotation(estimate.cam_from_target.rotation * pose.rotation.transpose());
    const Eigen::Matrix3d covariance =
        kSigmaPx * kSigmaPx * estimate.unit_covariance.topLeftCorner<3, 3>();
    result.chi2 += w.dot(covariance.ldlt().solve(w)) / kTrials;
  }
  result.over_bound = std::sqrt(square / bound);
  return result;
}

TEST(LensSolvers, AKnownNoiseReachesTheBoundThroughAFisheye) {
  for (const char* const solver : {"huber", "gnc", "drop_largest", "consensus", "orpe_consensus",
                                   "orpe_tree", "orpe_weighed"}) {
    const Accuracy known = accuracy(solver, 0.5);
    // Each of 400 squares has a relative spread of about 1, so that their root is known to 0.025;
    // the solvers lose next to nothing.
    EXPECT_LT(known.over_bound, 1.1) << solver;
    // Of three degrees of freedom, with sqrt(6 / 400) = 0.12 of spread.
    EXPECT_NEAR(known.chi2, 3, 0.6) << solver;
  }
  // What is taken to be the same all over the image without the lens does not.
  EXPECT_GT(accuracy("lspe", 0.5).over_bound, 1.15);
}

TEST(LensSolvers, APointBeyondNinetyDegreesIsLeftOut) {
  Camera camera = centred_camera(640, 480, 150);
  camera.lens = KannalaBrandt{};
  Draw draw(6);
  Synthetic s = exact_problem(camera, cloud(9, draw), wide_pose(draw));
  s.problem.pixels[4] = {319.5 + 150 * 1.7, 239.5};  // 97 degrees
  for (const char* const name : {"lspe", "consensus"}) {
    const PoseEstimate estimate = find_pose_solver(name)->solve(s.problem, {});
    ASSERT_EQ(estimate.status, PoseStatus::kOk) << name;
    EXPECT_EQ(estimate.ignored, std::vector<int>{4}) << name;
    EXPECT_TRUE(is_pose_near(estimate.cam_from_target, s.cam_from_target, 1e-8, 1e-8)) << name;
  }
}

}  // namespace
}  // namespace sightline
