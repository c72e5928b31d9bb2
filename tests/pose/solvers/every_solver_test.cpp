// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// What holds for every solver of the catalogue.
#include <algorithm>
#include <cstring>
#include <numeric>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pose/bounds.h"
#include "pose/minimax_null.h"
#include "pose/solver.h"
#include "tests/pose/matchers.h"
#include "tests/pose/solvers/solving.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

using testing::IsEmpty;

Camera camera_with_lens() {
  Camera camera = centred_camera(640, 480, 500);
  camera.fy_px = 530;
  camera.cx_px = 300;
  camera.lens = BrownConrady{.k1 = -0.1, .k2 = 0.02, .p1 = 1e-3, .p2 = -1e-3, .k3 = 0};
  return camera;
}

class EverySolver : public testing::TestWithParam<PoseSolver> {
 protected:
  static PoseEstimate run(const PoseProblem& problem) { return GetParam().solve(problem, {}); }
};

INSTANTIATE_TEST_SUITE_P(Solvers, EverySolver,
                         testing::ValuesIn(pose_solvers().begin(), pose_solvers().end()),
                         [](const auto& solver) { return std::string(solver.param.name); });

/// Exact pixels round to 1e-13 px; a pixel is at most 0.01 rad of these targets.
constexpr double kExactRad = 1e-10;
constexpr double kExactFraction = 1e-10;  // of the range

TEST_P(EverySolver, IsExactOnExactData) {
  Draw draw(1);
  for (int i = 0; i < 50; ++i) {
    const std::vector<Synthetic> cases = {
        cube_problem(0, draw),
        exact_problem(camera_with_lens(), points_in_box(10, {1, 1, 1}, draw),
                      {draw.rotation(), {0.4, -0.3, 5}}),
        exact_problem(camera_with_lens(), points_in_box(8, {1, 1, 0}, draw),
                      {draw.rotation(), {0.4, -0.3, 5}}),
        exact_problem(centred_camera(512, 512, 10000), points_in_box(5, {20, 20, 5}, draw),
                      {draw.rotation(), {-5, 5, 1300}})};
    for (const Synthetic& s : cases) {
      // OpenCV solves its samples of five points by EPnP, which coplanar ones defeat: it finds no
      // consensus in one draw of seven, and a part of it in one of three.
      const bool is_coplanar = &s == &cases[2];
      if (is_coplanar && GetParam().name == "opencv_ransac") continue;
      const PoseEstimate estimate = run(s.problem);
      ASSERT_EQ(estimate.status, PoseStatus::kOk);
      EXPECT_THAT(estimate.removed, IsEmpty());
      const double range = s.cam_from_target.translation.norm();
      // Near coplanar draws of the second and third kind magnify rounding.
      EXPECT_TRUE(is_pose_near(estimate.cam_from_target, s.cam_from_target, 1e3 * kExactRad,
                               1e3 * kExactFraction * range));
    }
  }
}

TEST_P(EverySolver, StartsFromTheInitialPoseToo) {
  Draw draw(2);
  for (int i = 0; i < 50; ++i) {
    Synthetic s = cube_problem(0, draw);
    s.problem.initial_cam_from_target = {draw.rotation_by(0.3) * s.cam_from_target.rotation,
                                         1.1 * s.cam_from_target.translation};
    const PoseEstimate estimate = run(s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    EXPECT_TRUE(
        is_pose_near(estimate.cam_from_target, s.cam_from_target, kExactRad, 100 * kExactFraction));
  }
}

TEST_P(EverySolver, OrderOfPointsDoesNotMatter) {
  Draw draw(3);
  std::mt19937_64 engine(3);
  for (int i = 0; i < 20; ++i) {
    Synthetic s = cube_problem(0.3, draw);
    add_outlier(s.problem, draw.index(8), 30, draw);
    const PoseEstimate estimate = run(s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);

    std::vector<int> order(8);
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), engine);
    PoseProblem shuffled = s.problem;
    std::vector<int> expected_removed;
    for (int k = 0; k < 8; ++k) {
      shuffled.points_in_target[k] = s.problem.points_in_target[order[k]];
      shuffled.pixels[k] = s.problem.pixels[order[k]];
      shuffled.true_inliers[k] = s.problem.true_inliers[order[k]];
      if (std::ranges::count(estimate.removed, order[k])) expected_removed.push_back(k);
    }
    const PoseEstimate other = run(shuffled);
    ASSERT_EQ(other.status, PoseStatus::kOk);
    EXPECT_EQ(other.removed, expected_removed);
    EXPECT_TRUE(is_pose_near(other.cam_from_target, estimate.cam_from_target, 1e-6, 1e-4));
  }
}

TEST_P(EverySolver, ChoiceOfTargetFrameDoesNotMatter) {
  Draw draw(4);
  for (int i = 0; i < 20; ++i) {
    const Synthetic s = cube_problem(1, draw);
    const Pose other_from_target = {draw.rotation(), draw.in_box(10)};
    PoseProblem other = s.problem;
    for (auto& x : other.points_in_target) x = other_from_target * x;
    const PoseEstimate a = run(s.problem);
    const PoseEstimate b = run(other);
    ASSERT_EQ(a.status, PoseStatus::kOk);
    ASSERT_EQ(b.status, PoseStatus::kOk);
    EXPECT_EQ(a.removed, b.removed);
    EXPECT_TRUE(is_pose_near(b.cam_from_target * other_from_target, a.cam_from_target, 1e-6, 1e-4));
  }
}

TEST_P(EverySolver, UnitOfLengthDoesNotMatter) {
  Draw draw(5);
  for (const double scale : {1e-6, 1e-3, 1e3, 1e6}) {
    const Synthetic s = cube_problem(1, draw);
    PoseProblem scaled = s.problem;
    for (auto& x : scaled.points_in_target) x *= scale;
    const PoseEstimate a = run(s.problem);
    PoseEstimate b = run(scaled);
    ASSERT_EQ(a.status, PoseStatus::kOk);
    ASSERT_EQ(b.status, PoseStatus::kOk);
    b.cam_from_target.translation /= scale;
    EXPECT_TRUE(is_pose_near(b.cam_from_target, a.cam_from_target, 1e-6, 1e-4));
  }
}

TEST_P(EverySolver, ErrorsGrowLinearlyWithSmallNoise) {
  Draw draw(6);
  for (int i = 0; i < 20; ++i) {
    const Synthetic exact = cube_problem(0, draw);
    PoseProblem noise = exact.problem;
    add_noise(noise, 1, draw);
    const auto error_rad = [&](double scale) {
      PoseProblem noisy = exact.problem;
      for (int k = 0; k < 8; ++k) {
        noisy.pixels[k] += scale * (noise.pixels[k] - exact.problem.pixels[k]);
      }
      return geodesic_angle_rad(run(noisy).cam_from_target.rotation,
                                exact.cam_from_target.rotation);
    };
    const double small = error_rad(1e-3);
    EXPECT_GT(small, 0);
    EXPECT_NEAR(error_rad(1e-2) / small, 10, 0.2);
  }
}

TEST_P(EverySolver, SameInputSameBytes) {
  Draw draw(7);
  for (int i = 0; i < 20; ++i) {
    Synthetic s = cube_problem(1, draw);
    add_outlier(s.problem, 0, 20, draw);
    const PoseEstimate a = run(s.problem);
    const PoseEstimate b = run(s.problem);
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.removed, b.removed);
    EXPECT_EQ(a.iterations, b.iterations);
    EXPECT_EQ(std::memcmp(&a.cam_from_target, &b.cam_from_target, sizeof(Pose)), 0);
    EXPECT_EQ(std::memcmp(&a.unit_covariance, &b.unit_covariance, sizeof(Matrix6d)), 0);
  }
}

TEST_P(EverySolver, ToleranceThatIsNoneIsTheFinestThereIs) {
  Draw draw(38);
  for (const double tolerance : {0.0, -1.0, kNaN}) {
    const Synthetic s = cube_problem(0, draw);
    SolverOptions options;
    options.lspe.step_tolerance = tolerance;
    const PoseEstimate estimate = GetParam().solve(s.problem, options);
    ASSERT_EQ(estimate.status, PoseStatus::kOk) << tolerance;
    EXPECT_TRUE(is_pose_near(estimate.cam_from_target, s.cam_from_target, 1e-6, 1e-4));
  }
}

TEST_P(EverySolver, TooFewPointsSaySo) {
  Draw draw(8);
  const Synthetic s = cube_problem(0.1, draw);
  for (std::size_t n = 0; n < 8; ++n) {
    for (const bool has_initial : {false, true}) {
      PoseProblem some = first_points(s.problem, n);
      if (has_initial) some.initial_cam_from_target = s.cam_from_target;
      const PoseEstimate estimate = run(some);
      const int minimum = has_initial ? 3 : kMinimumPosePoints;
      const bool is_enough = static_cast<int>(n) >= minimum;
      EXPECT_EQ(estimate.status, is_enough ? PoseStatus::kOk : PoseStatus::kTooFewPoints) << n;
      EXPECT_TRUE(is_free_of_nan(estimate));
    }
  }
}

TEST_P(EverySolver, ThreePointsAreMetExactlyNearTheInitialPose) {
  Draw draw(36);
  for (int i = 0; i < 20; ++i) {
    const Synthetic s = cube_problem(0, draw);
    PoseProblem three = first_points(s.problem, 3);
    three.initial_cam_from_target = s.cam_from_target;
    const PoseEstimate estimate = run(three);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    EXPECT_TRUE(estimate.removed.empty());
    EXPECT_LT(geodesic_angle_rad(estimate.cam_from_target.rotation, s.cam_from_target.rotation),
              1e-6);
  }
}

TEST_P(EverySolver, ListsOfDifferentLengthsSaySo) {
  Draw draw(9);
  PoseProblem problem = cube_problem(0.1, draw).problem;
  problem.pixels.pop_back();
  EXPECT_EQ(run(problem).status, PoseStatus::kTooFewPoints);
}

TEST_P(EverySolver, DegenerateInputSaysSo) {
  Draw draw(10);
  const Synthetic s = cube_problem(0, draw);
  for (const bool has_initial : {false, true}) {
    PoseProblem base = s.problem;
    if (has_initial) base.initial_cam_from_target = s.cam_from_target;

    std::vector<PoseProblem> cases;
    PoseProblem line = base;
    for (auto& x : line.points_in_target) x = Eigen::Vector3d(1, 2, 3) * draw.uniform(-0.3, 0.3);
    cases.push_back(line);
    PoseProblem spot = base;
    for (auto& x : spot.points_in_target) x = {0.1, 0.2, 0.3};
    cases.push_back(spot);
    for (const double bad : {kNaN, kInfinity}) {
      cases.push_back(base);
      cases.back().camera.fx_px = bad;
      cases.push_back(base);
      for (auto& pixel : cases.back().pixels) pixel.x() = bad;
    }
    cases.push_back(base);
    cases.back().camera.fy_px = 0;
    cases.push_back(base);
    std::get<BrownConrady>(cases.back().camera.lens).k1 = -1e6;  // folds within the image

    for (std::size_t i = 0; i < cases.size(); ++i) {
      const PoseEstimate estimate = run(cases[i]);
      EXPECT_EQ(estimate.status, PoseStatus::kDegenerate) << "case " << i;
      EXPECT_TRUE(is_free_of_nan(estimate)) << "case " << i;
    }
  }
}

TEST_P(EverySolver, ImageThatCollapsesIsNotOk) {
  Draw draw(11);
  PoseProblem problem = cube_problem(0, draw).problem;
  for (auto& u : problem.pixels) u = {200, 300};
  const PoseEstimate estimate = run(problem);
  EXPECT_NE(estimate.status, PoseStatus::kOk);
  EXPECT_TRUE(is_free_of_nan(estimate));
}

TEST_P(EverySolver, NoPoseThatIsOkHasAPointBehindTheCamera) {
  Draw draw(13);
  int ok = 0;
  for (int i = 0; i < 200; ++i) {
    // A target that surrounds the camera, and one whose pixels are those of its mirror image.
    Camera camera = centred_camera(640, 480, 300);
    PoseProblem problem;
    problem.camera = camera;
    problem.points_in_target = points_in_box(8, {1, 1, 1}, draw);
    problem.true_inliers.assign(8, true);
    const Pose cam_from_target = {draw.rotation(), {0, 0, i % 2 ? 0.3 : -3.0}};
    for (const auto& x_in_target : problem.points_in_target) {
      const Eigen::Vector3d x = cam_from_target * x_in_target;
      problem.pixels.emplace_back(300 * x.x() / x.z() + camera.cx_px,
                                  300 * x.y() / x.z() + camera.cy_px);
    }
    const PoseEstimate estimate = run(problem);
    EXPECT_TRUE(is_free_of_nan(estimate));
    if (estimate.status != PoseStatus::kOk) continue;
    ++ok;
    for (std::size_t k = 0; k < 8; ++k) {
      if (std::ranges::count(estimate.removed, static_cast<int>(k))) continue;
      EXPECT_GT((estimate.cam_from_target * problem.points_in_target[k]).z(), 0);
    }
  }
  EXPECT_GT(ok, 0);
}

TEST_P(EverySolver, RandomPixelsGiveNoNaN) {
  Draw draw(14);
  for (int i = 0; i < 100; ++i) {
    PoseProblem problem = cube_problem(0, draw).problem;
    for (auto& u : problem.pixels) u = {draw.uniform(0, 511), draw.uniform(0, 511)};
    const PoseEstimate estimate = run(problem);
    EXPECT_TRUE(is_free_of_nan(estimate));
    EXPECT_TRUE(is_valid(estimate.cam_from_target));
  }
}

TEST_P(EverySolver, OnlyThoseThatJudgeTheirAnswerSayHowGoodItIs) {
  Draw draw(40);
  Synthetic s = cube_problem(1, draw);
  s.problem.sigma_px = 1;
  SolverOptions unjudged;
  unjudged.is_judged = false;
  const PoseEstimate estimate = GetParam().solve(s.problem, unjudged);
  ASSERT_EQ(estimate.status, PoseStatus::kOk);
  const std::string_view name = GetParam().name;
  const bool is_weighing = name == "consensus" || name == "orpe_weighed";
  const bool sees_modes = is_weighing || name == "orpe_consensus";
  const bool is_testing = sees_modes || name == "orpe_calibrated" || name == "orpe_tree";
  EXPECT_EQ(estimate.covariance.has_value(), sees_modes);
  ASSERT_EQ(estimate.diagnosis.has_value(), is_testing);
  // The common entry adds what is missing.
  const Diagnosis judged = run(s.problem).diagnosis.value();
  EXPECT_TRUE(judged.is_ambiguous.has_value());
  EXPECT_TRUE(judged.is_test_failed.has_value());
  EXPECT_TRUE(judged.is_significant.has_value());
  if (!is_testing) return;
  EXPECT_TRUE(estimate.diagnosis->is_removal_limit_reached.has_value());
  EXPECT_TRUE(estimate.diagnosis->is_test_failed.has_value());
  EXPECT_EQ(estimate.diagnosis->is_ambiguous.has_value(), sees_modes);
  EXPECT_EQ(estimate.diagnosis->removed_probability.has_value(), is_weighing);
  EXPECT_EQ(estimate.diagnosis->most_probable_cam_from_target.has_value(), is_weighing);
}

TEST_P(EverySolver, CovarianceIsTheBoundOnExactData) {
  Draw draw(15);
  for (int i = 0; i < 20; ++i) {
    std::vector<Eigen::Vector3d> vertices = cube_vertices();
    for (auto& x : vertices) x += Eigen::Vector3d(2, -1, 0.5);
    const Synthetic s = exact_problem(centred_camera(512, 512, 15000), vertices, cube_pose(draw));
    const PoseEstimate estimate = run(s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    // The minimax of eight points is no estimate that reaches the bound.
    const std::string_view name = GetParam().name;
    const bool is_minimax = name == "orpe" || name.starts_with("minimax");
    const double factor = is_minimax ? minimax_variance_factor(8) : 1;
    const Matrix6d expected =
        factor *
        cramer_rao_bound(s.problem.camera, s.problem.points_in_target, s.cam_from_target, 1)
            ->covariance;
    EXPECT_TRUE(is_matrix_near(estimate.unit_covariance, expected, 1e-6 * expected.norm()));
  }
}

}  // namespace
}  // namespace sightline
