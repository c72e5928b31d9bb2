// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// No input does harm: what the common entry (pose/entry/) promises of every solver of the
// catalogue. The twin of a case is the solver's own function, which refuses or goes wrong there, or
// the same problem without what is wrong with it.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pose/solver.h"
#include "tests/pose/matchers.h"
#include "tests/pose/solvers/solving.h"
#include "tests/pose/synthetic.h"

namespace sightline {

namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Exact pixels are rounded to 1e-13 px, of some hundred that the target covers; what robust
/// solvers make of it is a thousand times as much at worst.
constexpr double kNearRad = 1e-7;
constexpr double kNearM = 1e-6;

class AnyInput : public testing::TestWithParam<PoseSolver> {
 protected:
  static PoseEstimate run(const PoseProblem& problem) { return GetParam().solve(problem); }
  static PoseEstimate core(const PoseProblem& problem) { return GetParam().core(problem, {}); }
  static bool is(std::string_view name) { return GetParam().name == name; }
};

INSTANTIATE_TEST_SUITE_P(Solvers, AnyInput,
                         testing::ValuesIn(pose_solvers().begin(), pose_solvers().end()),
                         [](const auto& solver) { return std::string(solver.param.name); });

/// Ten points in a box of 2 m about 6 m away, seen by 800 px.
Synthetic near_box(Draw& draw, double depth = 1) {
  const Pose pose = {draw.rotation(), {draw.uniform(-0.3, 0.3), draw.uniform(-0.3, 0.3), 6}};
  return exact_problem(centred_camera(640, 480, 800), points_in_box(10, {1, 1, depth}, draw), pose);
}

testing::AssertionResult is_truth(const PoseEstimate& estimate, const Synthetic& s) {
  if (estimate.status != PoseStatus::kOk) {
    return testing::AssertionFailure() << "status " << to_string(estimate.status);
  }
  return is_pose_near(estimate.cam_from_target, s.cam_from_target, kNearRad, kNearM);
}

TEST_P(AnyInput, PointThatCannotBeUsedIsLeftOutAndListed) {
  Draw draw(101);
  const Synthetic s = near_box(draw);
  std::vector<PoseProblem> cases;
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    cases.push_back(s.problem);
    cases.back().pixels[3].x() = bad;
    cases.push_back(s.problem);
    cases.back().points_in_target[3].z() = bad;
  }
  cases.push_back(s.problem);
  cases.back().points_in_target[3].y() = 1e200;
  Eigen::Matrix2d indefinite, asymmetric;
  indefinite << 1, 2, 2, 1;
  asymmetric << 1, 0.5, -0.5, 1;
  for (const Eigen::Matrix2d& bad :
       {Eigen::Matrix2d(Eigen::Matrix2d::Zero()), indefinite, Eigen::Matrix2d(-indefinite),
        Eigen::Matrix2d(Eigen::Matrix2d::Constant(kNaN))}) {
    cases.push_back(s.problem);
    cases.back().covariances_px2.assign(10, Eigen::Matrix2d::Identity());
    EXPECT_THAT(run(cases.back()).ignored, IsEmpty());
    cases.back().covariances_px2[3] = bad;
  }
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const PoseEstimate estimate = run(cases[i]);
    EXPECT_TRUE(is_truth(estimate, s)) << i;
    EXPECT_THAT(estimate.ignored, ElementsAre(3)) << i;
    EXPECT_THAT(estimate.removed, IsEmpty()) << i;
    EXPECT_TRUE(is_free_of_nan(estimate)) << i;
  }
  EXPECT_THAT(run(s.problem).ignored, IsEmpty());
}

TEST_P(AnyInput, PixelBeyondTheFoldOfTheLensIsLeftOut) {
  Draw draw(102);
  Camera camera = centred_camera(640, 480, 450);
  std::get<BrownConrady>(camera.lens).k1 = -0.45;
  const Synthetic s =
      exact_problem(camera, points_in_box(10, {1, 1, 1}, draw), {draw.rotation(), {0, 0, 6}});
  PoseProblem beyond = s.problem;
  beyond.pixels[9] = {2, 2};
  const PoseEstimate estimate = run(beyond);
  EXPECT_TRUE(is_truth(estimate, s));
  EXPECT_THAT(estimate.ignored, ElementsAre(9));
}

TEST_P(AnyInput, TooFewUsablePointsSaySoAndListTheOthers) {
  Draw draw(103);
  PoseProblem problem = first_points(near_box(draw).problem, 6);
  for (const int i : {0, 2, 5}) problem.pixels[i].x() = kNaN;
  const PoseEstimate estimate = run(problem);
  EXPECT_EQ(estimate.status, PoseStatus::kDegenerate);
  EXPECT_THAT(estimate.ignored, ElementsAre(0, 2, 5));
}

TEST_P(AnyInput, FarPointOrPointBehindTheCameraIsAnOutlierLikeAnyOther) {
  if (is("opencv_ransac")) GTEST_SKIP() << "its samples of five find no consensus here";
  Draw draw(104);
  for (const double far : {30.0, 1e3, 1e6}) {
    Synthetic s = near_box(draw);
    s.problem.sigma_px = 0.5;
    // Behind the camera, and seen where the line through the camera's centre leads.
    const Eigen::Vector3d x_in_cam = {0.1 * far, -0.05 * far, -far};
    s.problem.points_in_target[4] = inverse(s.cam_from_target) * x_in_cam;
    s.problem.pixels[4] = {800 * -0.1 + 319.5, 800 * 0.05 + 239.5};
    s.problem.true_inliers[4] = false;
    const PoseEstimate estimate = run(s.problem);
    EXPECT_TRUE(is_truth(estimate, s)) << far;
    EXPECT_THAT(estimate.removed, ElementsAre(4)) << far;
  }
}

TEST_P(AnyInput, PointsGivenTwiceCountOnce) {
  if (is("opencv_ransac")) GTEST_SKIP() << "its samples of five find no consensus here";
  Draw draw(105);
  const Synthetic s = near_box(draw);
  PoseProblem three = first_points(s.problem, 3);
  for (const std::size_t i : {0, 1, 1}) {
    three.points_in_target.push_back(s.problem.points_in_target[i]);
    three.pixels.push_back(s.problem.pixels[i]);
    three.true_inliers.push_back(true);
  }
  EXPECT_EQ(run(three).status, PoseStatus::kDegenerate);
  PoseProblem all = s.problem;  // a fourth point makes the twin
  for (const std::size_t i : {0, 1, 1}) {
    all.points_in_target.push_back(s.problem.points_in_target[i]);
    all.pixels.push_back(s.problem.pixels[i]);
    all.true_inliers.push_back(true);
  }
  EXPECT_TRUE(is_truth(run(all), s));
}

TEST_P(AnyInput, InitialPoseCanOnlyHelp) {
  Draw draw(106);
  for (int i = 0; i < 10; ++i) {
    Synthetic s = near_box(draw);
    std::vector<Pose> initials(7, s.cam_from_target);
    initials[0].rotation = s.cam_from_target.rotation.cast<float>().cast<double>();
    initials[1].rotation = (1e4 * s.cam_from_target.rotation).array().round() / 1e4;
    initials[2].rotation(1, 2) = kNaN;
    initials[3].rotation.row(2) *= -1;       // a reflection
    initials[4].translation.z() = -6;        // the target is behind
    initials[5].translation.z() = 0.1;       // half of it is
    initials[6].rotation = draw.rotation();  // any attitude
    for (std::size_t k = 0; k < initials.size(); ++k) {
      s.problem.initial_cam_from_target = initials[k];
      EXPECT_TRUE(is_truth(run(s.problem), s)) << k;
      EXPECT_THAT(run(s.problem).ignored, IsEmpty()) << k;
    }
  }
}

TEST_P(AnyInput, PointBehindAGoodInitialPoseIsLeftOut) {
  Draw draw(107);
  Synthetic s = near_box(draw);
  s.problem.initial_cam_from_target = s.cam_from_target;
  s.problem.points_in_target[2] = inverse(s.cam_from_target) * Eigen::Vector3d(1, -1, -4);
  s.problem.true_inliers[2] = false;
  const PoseEstimate estimate = run(s.problem);
  EXPECT_TRUE(is_truth(estimate, s));
  EXPECT_EQ(std::ranges::count(estimate.ignored, 2) + std::ranges::count(estimate.removed, 2), 1);
}

/// A plane seen under strong perspective, from an initial pose that is its mirror pose.
TEST_P(AnyInput, MirrorPoseOfAPlaneIsLeft) {
  if (is("opencv_ransac")) GTEST_SKIP() << "its samples of five find no consensus here";
  Draw draw(108);
  int stuck = 0;
  for (int i = 0; i < 10; ++i) {
    const Pose truth = {rotation_from_vector({draw.uniform(0.4, 0.9), draw.uniform(-0.5, 0.5), 0}),
                        {0.1, 0.2, 4}};
    Synthetic s =
        exact_problem(centred_camera(640, 480, 600), points_in_box(8, {1, 1, 0}, draw), truth);
    // The plane's normal mirrored at the ray to its middle.
    const Eigen::Vector3d ray = truth.translation.normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - 2 * ray * ray.transpose();
    const Eigen::Matrix3d flip = Eigen::Vector3d(1, 1, -1).asDiagonal();
    s.problem.initial_cam_from_target = Pose{across * truth.rotation * flip, truth.translation};
    EXPECT_TRUE(is_truth(run(s.problem), s)) << i;
    const PoseEstimate alone = core(s.problem);
    stuck += alone.status != PoseStatus::kOk || !is_truth(alone, s);
  }
  const bool leaves = GetParam().takes_any_input || is("ransac_p3p") || is("gnc");
  if (!leaves) {
    EXPECT_GT(stuck, 0);
  }
}

TEST_P(AnyInput, PlaneFromFarAwayIsAmbiguousWithAndWithoutAnInitialPose) {
  if (is("opencv_ransac")) GTEST_SKIP() << "its samples of five find no consensus here";
  Draw draw(109);
  for (int i = 0; i < 5; ++i) {
    const Pose truth = {rotation_from_vector({0.6, 0.2, 0.1}), {0.1, 0.2, 500}};
    Synthetic s =
        exact_problem(centred_camera(640, 480, 50000), points_in_box(8, {1, 1, 0}, draw), truth);
    add_noise(s.problem, 1, draw);
    s.problem.sigma_px = 1;
    const PoseEstimate free = run(s.problem);
    s.problem.initial_cam_from_target = truth;
    const PoseEstimate helped = run(s.problem);
    for (const PoseEstimate& estimate : {free, helped}) {
      ASSERT_EQ(estimate.status, PoseStatus::kOk);
      EXPECT_TRUE(is_ambiguous(estimate));
    }
    // The initial pose decides between the two, but for those that choose by evidence alone.
    if (!GetParam().takes_any_input && !is("ransac_p3p")) {
      EXPECT_LT(geodesic_angle_rad(helped.cam_from_target.rotation, truth.rotation), 0.3);
    }
    // Where nothing is far away only one of the two poses is left.
    Synthetic near = exact_problem(centred_camera(640, 480, 600), points_in_box(8, {1, 1, 0}, draw),
                                   {truth.rotation, {0, 0, 4}});
    near.problem.sigma_px = 0.3;
    EXPECT_FALSE(is_ambiguous(run(near.problem)));
  }
}

TEST_P(AnyInput, EverySolverSaysWhatItsResidualsAre) {
  Draw draw(110);
  Synthetic s = near_box(draw);
  add_noise(s.problem, 0.5, draw);
  for (const double sigma_px : {0.0, 0.5}) {
    s.problem.sigma_px = sigma_px;
    const PoseEstimate estimate = run(s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    double squares = 0, kept = 0;
    for (std::size_t i = 0; i < 10; ++i) {
      if (std::ranges::count(estimate.removed, static_cast<int>(i))) continue;
      squares += squared_error_px2(s.problem, i, estimate.cam_from_target);
      ++kept;
    }
    EXPECT_NEAR(estimate.residual_rms_px.value(), std::sqrt(squares / (2 * kept)), 1e-6);
    EXPECT_FALSE(is_test_failed(estimate));
    EXPECT_TRUE(estimate.diagnosis->is_significant.value());
  }
  PoseProblem nonsense = s.problem;
  for (auto& pixel : nonsense.pixels) pixel = {draw.uniform(0, 639), draw.uniform(0, 479)};
  const PoseEstimate estimate = run(nonsense);
  if (estimate.status != PoseStatus::kOk || !estimate.residual_rms_px) return;
  EXPECT_TRUE(is_test_failed(estimate) || !estimate.diagnosis->is_significant.value());
}

/// From afar a mirrored target looks like its mirror image in depth, up to some 1 to 4 % of its
/// image here: where the noise is known that is no noise.
TEST_P(AnyInput, MirroredTargetIsFlagged) {
  Draw draw(111);
  int flagged = 0;
  constexpr int kDraws = 10;
  for (int i = 0; i < kDraws; ++i) {
    Synthetic s = near_box(draw);
    s.problem.sigma_px = 0.5;
    EXPECT_TRUE(run(s.problem).diagnosis->is_significant.value());
    EXPECT_FALSE(is_test_failed(run(s.problem)));
    for (auto& x : s.problem.points_in_target) x.x() = -x.x();
    const PoseEstimate estimate = run(s.problem);
    flagged += estimate.status != PoseStatus::kOk || !estimate.residual_rms_px ||
               !estimate.diagnosis->is_significant.value() || is_test_failed(estimate);
  }
  EXPECT_GE(flagged, kDraws - 1);
}

/// The same rays as of a camera of 1024 px, by K = I.
PoseProblem in_normalised_coordinates(const PoseProblem& problem) {
  PoseProblem normalised = problem;
  normalised.camera = {.width_px = 2,
                       .height_px = 2,
                       .fx_px = 1,
                       .fy_px = 1,
                       .cx_px = 0,
                       .cy_px = 0,
                       .lens = {}};
  for (auto& u : normalised.pixels) u = (u - Eigen::Vector2d(319.5, 239.5)) / 1024;
  for (auto& covariance : normalised.covariances_px2) covariance /= 1024.0 * 1024.0;
  normalised.sigma_px /= 1024;
  return normalised;
}

/// Solid and planar, noise told, by covariances or not at all, with and without an initial pose.
TEST_P(AnyInput, UnitsDoNotMatterWhateverIsKnown) {
  if (is("opencv_ransac")) GTEST_SKIP() << "its samples of five find no consensus here";
  Draw draw(115);
  for (int i = 0; i < 24; ++i) {
    Synthetic s = near_box(draw, i % 2);
    s.problem.camera = centred_camera(640, 480, 1024);
    for (std::size_t k = 0; k < 10; ++k) {
      s.problem.pixels[k] =
          project(s.problem.camera, s.cam_from_target * s.problem.points_in_target[k]).value();
    }
    add_noise(s.problem, 1, draw);
    add_outlier(s.problem, 1, 60, draw);
    if (i / 2 % 3 == 0) s.problem.sigma_px = 1;
    if (i / 2 % 3 == 1) s.problem.covariances_px2.assign(10, Eigen::Vector2d(1, 2).asDiagonal());
    if (i / 6 % 2 == 0) {
      s.problem.initial_cam_from_target = {draw.rotation_by(0.05) * s.cam_from_target.rotation,
                                           s.cam_from_target.translation};
    }
    const PoseEstimate a = run(s.problem), b = run(in_normalised_coordinates(s.problem));
    ASSERT_EQ(a.status, b.status) << i;
    if (a.status != PoseStatus::kOk) continue;
    EXPECT_EQ(a.removed, b.removed) << i;
    EXPECT_TRUE(is_pose_near(b.cam_from_target, a.cam_from_target, 1e-6, 1e-5)) << i;
    ASSERT_EQ(a.residual_rms_px.has_value(), b.residual_rms_px.has_value());
    if (!a.residual_rms_px) continue;
    const double unit = s.problem.covariances_px2.empty() ? 1024 : 1;
    EXPECT_NEAR(*b.residual_rms_px * unit / *a.residual_rms_px, 1, 1e-4) << i;
    EXPECT_EQ(is_test_failed(a), is_test_failed(b)) << i;
    EXPECT_EQ(is_ambiguous(a), is_ambiguous(b)) << i;
    EXPECT_EQ(a.diagnosis->is_significant, b.diagnosis->is_significant) << i;
  }
}

/// Random shares of outliers and pixels without any pose: what every solver says of its answer is
/// what its residuals are, and nonsense is never taken for a pose.
TEST_P(AnyInput, EverySolverSaysWhatItLeavesAndFlagsNonsense) {
  Draw draw(116);
  int flagged = 0, answered = 0;
  for (int i = 0; i < 20; ++i) {
    Synthetic s = near_box(draw);
    add_noise(s.problem, 0.5, draw);
    s.problem.sigma_px = i % 2 ? 0.5 : 0;
    for (int k = 0; k < i % 4; ++k) add_outlier(s.problem, k, 80, draw);
    const PoseEstimate estimate = run(s.problem);
    if (estimate.status != PoseStatus::kOk) continue;
    const Diagnosis said = estimate.diagnosis.value();
    EXPECT_TRUE(said.is_ambiguous.has_value() || !estimate.residual_rms_px);
    EXPECT_TRUE(is_free_of_nan(estimate));
    PoseProblem nonsense = s.problem;
    for (auto& pixel : nonsense.pixels) pixel = {draw.uniform(0, 639), draw.uniform(0, 479)};
    const PoseEstimate none = run(nonsense);
    if (none.status != PoseStatus::kOk || !none.residual_rms_px) continue;
    ++answered;
    flagged += is_test_failed(none) || !none.diagnosis->is_significant.value();
  }
  EXPECT_EQ(flagged, answered);
}

/// The same rays, by a camera of 1024 px and by K = I.
TEST_P(AnyInput, NormalisedCoordinatesGiveTheSameAnswer) {
  Draw draw(112);
  for (const double sigma_px : {0.0, 1.0}) {
    Synthetic s = near_box(draw);
    s.problem.camera = centred_camera(640, 480, 1024);
    for (std::size_t i = 0; i < 10; ++i) {
      s.problem.pixels[i] =
          project(s.problem.camera, s.cam_from_target * s.problem.points_in_target[i]).value();
    }
    add_noise(s.problem, 1, draw);
    add_outlier(s.problem, 1, 60, draw);
    s.problem.sigma_px = sigma_px;
    const PoseEstimate a = run(s.problem), b = run(in_normalised_coordinates(s.problem));
    ASSERT_EQ(a.status, PoseStatus::kOk);
    ASSERT_EQ(b.status, PoseStatus::kOk);
    EXPECT_EQ(a.removed, b.removed);
    EXPECT_TRUE(is_pose_near(b.cam_from_target, a.cam_from_target, 1e-6, 1e-5));
    EXPECT_NEAR(*b.residual_rms_px * 1024 / *a.residual_rms_px, 1, 1e-4);
    EXPECT_TRUE(is_matrix_near(b.unit_covariance / (1024 * 1024), a.unit_covariance,
                               1e-3 * a.unit_covariance.norm()));
  }
}

/// What is right stays as the solver's own function has it, bit for bit.
TEST_P(AnyInput, PlainProblemsAreLeftAlone) {
  Draw draw(113);
  for (int i = 0; i < 20; ++i) {
    Synthetic s = cube_problem(1, draw);
    s.problem.sigma_px = i % 2;
    add_outlier(s.problem, draw.index(8), 20, draw);
    if (i % 3 == 0) {
      s.problem.initial_cam_from_target = {draw.rotation_by(0.03) * s.cam_from_target.rotation,
                                           s.cam_from_target.translation};
    }
    const PoseEstimate own = core(s.problem), all = run(s.problem);
    ASSERT_EQ(own.status, all.status);
    EXPECT_EQ(own.removed, all.removed);
    EXPECT_EQ(std::memcmp(&own.cam_from_target, &all.cam_from_target, sizeof(Pose)), 0);
    EXPECT_EQ(std::memcmp(&own.unit_covariance, &all.unit_covariance, sizeof(Matrix6d)), 0);
  }
}

TEST(AnyInputLimit, TooManyPointsAreRefusedBySolversThatHaveNoTimeForThem) {
  Draw draw(114);
  for (const PoseSolver& solver : pose_solvers()) {
    if (solver.most_points == 0) continue;
    const int most = static_cast<int>(solver.most_points);
    Synthetic s =
        exact_problem(centred_camera(640, 480, 800), points_in_box(most + 1, {1, 1, 1}, draw),
                      {draw.rotation(), {0, 0, 6}});
    EXPECT_EQ(solver.solve(s.problem).status, PoseStatus::kTooManyPoints) << solver.name;
    EXPECT_TRUE(is_truth(solver.solve(first_points(s.problem, solver.most_points)), s))
        << solver.name;
  }
}

}  // namespace
}  // namespace sightline
