// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
//
// Poses of points and lines together.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "pose/bounds.h"
#include "pose/solver.h"
#include "tests/pose/lines/seen_lines.h"

namespace sightline {
namespace {

const PoseSolver& solver(const char* name) {
  return *find_pose_solver(name);
}

double nees(const PoseEstimate& estimate, const Pose& truth) {
  const Vector6d error = change_between(truth, estimate.cam_from_target);
  return error.dot(estimate.covariance.value().inverse() * error);
}

double turn_rad(const PoseEstimate& estimate, const Pose& truth) {
  return geodesic_angle_rad(estimate.cam_from_target.rotation, truth.rotation);
}

class SolversWithLines : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, SolversWithLines, testing::Values("lspe", "consensus"));

TEST_P(SolversWithLines, FindTheExactPose) {
  Draw draw(80);
  for (int k = 0; k < 10; ++k) {
    Synthetic s = cube_with_lines(1e-4, 1e-4, draw);
    const PoseEstimate estimate = solver(GetParam()).solve(s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    EXPECT_LT(turn_rad(estimate, s.cam_from_target), 1e-5) << k;
  }
}

TEST_P(SolversWithLines, StateTheirCovarianceTruly) {
  // The mean of 300 values of chi-squared with 6 degrees of freedom has a deviation of 0.2.
  Draw draw(81);
  double sum = 0;
  constexpr int kDraws = 300;
  for (int k = 0; k < kDraws; ++k) {
    const Synthetic s = cube_with_lines(0.5, 2, draw);
    const PoseEstimate estimate = solver(GetParam()).solve(s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    sum += nees(estimate, s.cam_from_target);
  }
  EXPECT_NEAR(sum / kDraws, 6, 0.8);
}

TEST_P(SolversWithLines, ReachTheBound) {
  Draw draw(82);
  double squares = 0, bounds = 0;
  for (int k = 0; k < 200; ++k) {
    const Synthetic s = cube_with_lines(0.5, 2, draw);
    const PoseProblem& p = s.problem;
    const std::vector<Eigen::Matrix2d> covariances(p.pixels.size(),
                                                   0.25 * Eigen::Matrix2d::Identity());
    const auto bound =
        cramer_rao_bound(p.camera, p.points_in_target, s.cam_from_target, covariances, p.lines);
    ASSERT_TRUE(bound);
    const double turn = turn_rad(solver(GetParam()).solve(p), s.cam_from_target);
    squares += turn * turn;
    bounds += bound->geodesic_rms_rad * bound->geodesic_rms_rad;
  }
  // 200 draws of three degrees of freedom: the ratio of the roots is known to some 3 %.
  EXPECT_NEAR(std::sqrt(squares / bounds), 1, 0.1);
}

TEST_P(SolversWithLines, NeedNoPointsAndNoInitialPose) {
  Draw draw(83);
  const Camera camera = centred_camera(512, 512, 15000);
  for (int k = 0; k < 10; ++k) {
    const Pose truth = cube_pose(draw);
    const PoseProblem problem = random_lines(camera, truth, 10, draw);
    const PoseEstimate estimate = solver(GetParam()).solve(problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    EXPECT_LT(turn_rad(estimate, truth), 0.05) << k;
  }
}

TEST_P(SolversWithLines, LeaveOutWhatCannotBeUsed) {
  Draw draw(84);
  Synthetic s = cube_with_lines(0.5, 1, draw);
  s.problem.lines[3].pixel.x() = std::nan("");
  s.problem.lines[5].end_in_target = s.problem.lines[5].begin_in_target;
  s.problem.pixels[2].y() = std::nan("");
  const PoseEstimate estimate = solver(GetParam()).solve(s.problem);
  ASSERT_EQ(estimate.status, PoseStatus::kOk);
  EXPECT_EQ(estimate.ignored_lines, (std::vector<int>{3, 5}));
  EXPECT_EQ(estimate.ignored, std::vector<int>{2});
  EXPECT_LT(turn_rad(estimate, s.cam_from_target), 0.01);
}

TEST_P(SolversWithLines, SayWhyThereIsNoPose) {
  Draw draw(85);
  Synthetic s = cube_with_lines(0.5, 1, draw);
  s.problem.pixels.clear();
  s.problem.points_in_target.clear();
  s.problem.lines.resize(2);
  EXPECT_EQ(solver(GetParam()).solve(s.problem).status, PoseStatus::kTooFewPoints);
  // Four edges along one direction leave the position along them open.
  s = cube_with_lines(0.5, 1, draw);
  s.problem.pixels.clear();
  s.problem.points_in_target.clear();
  std::erase_if(s.problem.lines, [](const LineObservation& line) {
    const Eigen::Vector3d along = line.end_in_target - line.begin_in_target;
    return along.x() == 0;
  });
  ASSERT_EQ(s.problem.lines.size(), 4U);
  EXPECT_NE(solver(GetParam()).solve(s.problem).status, PoseStatus::kOk);
}

TEST_P(SolversWithLines, DoNotDependOnTheTargetsFrame) {
  Draw draw(86);
  Synthetic s = cube_with_lines(0.5, 1, draw);
  const PoseEstimate before = solver(GetParam()).solve(s.problem);
  const Eigen::Vector3d moved(300, -200, 100);
  for (Eigen::Vector3d& point : s.problem.points_in_target) point += moved;
  for (LineObservation& line : s.problem.lines) {
    line.begin_in_target += moved;
    line.end_in_target += moved;
  }
  Pose& initial = *s.problem.initial_cam_from_target;
  initial.translation -= initial.rotation * moved;
  const PoseEstimate after = solver(GetParam()).solve(s.problem);
  ASSERT_EQ(after.status, PoseStatus::kOk);
  EXPECT_LT((before.cam_from_target.rotation - after.cam_from_target.rotation).norm(), 1e-8);
}

TEST_P(SolversWithLines, DoNotDependOnTheOrderNorOnTheUnitOfPixels) {
  constexpr double kRounding = 1e-6;  // of iterations that stop at steps of 1e-8
  Draw draw(91);
  Synthetic s = cube_with_lines(0.5, 1, draw);
  const PoseEstimate given = solver(GetParam()).solve(s.problem);
  PoseProblem turned = s.problem;
  std::ranges::reverse(turned.lines);
  std::ranges::reverse(turned.pixels);
  std::ranges::reverse(turned.points_in_target);
  const PoseEstimate reversed = solver(GetParam()).solve(turned);
  EXPECT_LT(turn_rad(reversed, given.cam_from_target), kRounding);
  PoseProblem normalised = s.problem;
  const Camera camera = s.problem.camera;
  const double f = camera.fx_px;
  const Eigen::Vector2d centre(camera.cx_px, camera.cy_px);
  normalised.camera = {.fx_px = 1, .fy_px = 1, .cx_px = 0, .cy_px = 0, .lens = {}};
  normalised.sigma_px /= f;
  for (Eigen::Vector2d& pixel : normalised.pixels) pixel = (pixel - centre) / f;
  for (LineObservation& line : normalised.lines) {
    line.pixel = (line.pixel - centre) / f;
    line.covariance(0, 0) /= f * f;
  }
  const PoseEstimate same = solver(GetParam()).solve(normalised);
  ASSERT_EQ(same.status, PoseStatus::kOk);
  EXPECT_LT(turn_rad(same, given.cam_from_target), kRounding);
}

TEST_P(SolversWithLines, AreNotLedAstrayByAnInitialPoseThatIsWrong) {
  Draw draw(92);
  for (int k = 0; k < 5; ++k) {
    Synthetic s = cube_with_lines(0.5, 1, draw);
    s.problem.initial_cam_from_target->translation.z() = -10;  // all of it behind the camera
    const PoseEstimate with_points = solver(GetParam()).solve(s.problem);
    ASSERT_EQ(with_points.status, PoseStatus::kOk);
    EXPECT_LT(turn_rad(with_points, s.cam_from_target), 0.02);
    s.problem.pixels.clear();
    s.problem.points_in_target.clear();
    EXPECT_EQ(solver(GetParam()).solve(s.problem).status, PoseStatus::kOk);
  }
}

TEST_P(SolversWithLines, TakeLinesThatShowNoSlopeForOneNumberEach) {
  Draw draw(93);
  Synthetic s = cube_with_lines(0.5, 1, draw);
  s.problem.pixels.clear();
  s.problem.points_in_target.clear();
  s.problem.initial_cam_from_target.reset();
  for (LineObservation& line : s.problem.lines) {
    line.covariance = Eigen::Vector2d(1, std::numeric_limits<double>::infinity()).asDiagonal();
  }
  s.problem.lines.resize(6);
  EXPECT_EQ(solver(GetParam()).solve(s.problem).status, PoseStatus::kDegenerate);
}

TEST_P(SolversWithLines, CountWhatIsGivenTwiceOnceForWhatIsDetermined) {
  Draw draw(85);
  Synthetic s = cube_with_lines(0.1, 0.1, draw);
  PoseProblem& problem = s.problem;
  problem.initial_cam_from_target.reset();
  problem.points_in_target.resize(1);
  problem.pixels.resize(1);
  // Edges that meet neither each other nor the point, the cube's first vertex: with two of them it
  // would have a pose, but which of several nobody could say.
  problem.lines = {problem.lines[4], problem.lines[5], problem.lines[9]};
  EXPECT_EQ(solver(GetParam()).solve(problem).status, PoseStatus::kOk);

  PoseProblem same_edge = problem;
  LineObservation& again = same_edge.lines[2];
  again = same_edge.lines[0];
  std::swap(again.begin_in_target, again.end_in_target);
  again.pixel += Eigen::Vector2d(0.01, 0.02);
  EXPECT_EQ(solver(GetParam()).solve(same_edge).status, PoseStatus::kDegenerate);

  PoseProblem same_point = problem;
  same_point.lines.resize(2);
  same_point.points_in_target.push_back(problem.points_in_target[0]);
  same_point.pixels.emplace_back(problem.pixels[0] + Eigen::Vector2d(0.01, 0.02));
  EXPECT_EQ(solver(GetParam()).solve(same_point).status, PoseStatus::kDegenerate);
}

TEST(LinesInConsensus, AreAsManyAsOneLikes) {
  Draw draw(94);
  Synthetic s = cube_with_lines(0.5, 1, draw);
  const std::vector<LineObservation> twelve = s.problem.lines;
  for (int copy = 0; copy < 5; ++copy) {
    for (LineObservation line : twelve) {
      add_noise(line, draw);
      if (copy < 2) shift(line, draw.uniform(10, 30));
      s.problem.lines.push_back(line);
    }
  }
  s.problem.pixels.clear();
  s.problem.points_in_target.clear();
  const PoseEstimate estimate = solver("consensus").solve(s.problem);
  ASSERT_EQ(estimate.status, PoseStatus::kOk);
  EXPECT_LT(turn_rad(estimate, s.cam_from_target), 0.01);
  EXPECT_EQ(estimate.removed_lines.size(), 24U);
}

TEST(LinesInConsensus, WrongLinesAndPointsAreRemoved) {
  Draw draw(87);
  int exact = 0;
  for (int k = 0; k < 50; ++k) {
    Synthetic s = cube_with_lines(0.5, 2, draw);
    shift(s.problem.lines[0], 12);
    shift(s.problem.lines[4], -9);
    add_outlier(s.problem, 3, 25, draw);
    const PoseEstimate estimate = solver("consensus").solve(s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    exact +=
        estimate.removed_lines == std::vector<int>{0, 4} && estimate.removed == std::vector<int>{3};
    EXPECT_LT(turn_rad(estimate, s.cam_from_target), 0.02) << k;
  }
  EXPECT_GE(exact, 48);
  // Least squares, which removes nothing, is spoilt by them.
  Synthetic s = cube_with_lines(0.5, 2, draw);
  shift(s.problem.lines[0], 12);
  EXPECT_GT(turn_rad(solver("lspe").solve(s.problem), s.cam_from_target), 0.01);
}

TEST(LinesInConsensus, NoiseThatIsNotKnownIsFound) {
  Draw draw(88);
  double sum = 0;
  for (int k = 0; k < 40; ++k) {
    Synthetic s = cube_with_lines(3, 3, draw);
    for (LineObservation& line : s.problem.lines) line.covariance /= 9;  // as if of one pixel
    s.problem.sigma_px = 0;
    const PoseEstimate estimate = solver("consensus").solve(s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    sum += estimate.noise_px.value() / 40;
  }
  EXPECT_NEAR(sum, 3, 0.5);
}

TEST(LinesInConsensus, TellWhetherTheKeptLookLikeNoise) {
  Draw draw(89);
  Synthetic s = cube_with_lines(0.5, 2, draw);
  const PoseEstimate honest = solver("consensus").solve(s.problem);
  EXPECT_FALSE(honest.diagnosis->is_test_failed.value());
  EXPECT_TRUE(honest.diagnosis->is_significant.value());
  EXPECT_FALSE(honest.diagnosis->is_ambiguous.value());
  s.problem.sigma_px = 0.1;
  for (LineObservation& line : s.problem.lines) line.covariance /= 12;
  const PoseEstimate understated = solver("consensus").solve(s.problem);
  ASSERT_EQ(understated.status, PoseStatus::kOk);
  const bool has_removed = !understated.removed_lines.empty() || !understated.removed.empty();
  EXPECT_TRUE(understated.diagnosis->is_test_failed.value() || has_removed);
}

TEST(LinesInConsensus, AThirdOfWrongLinesIsRemovedFromAPoorStart) {
  Draw draw(95);
  int right = 0;
  for (int k = 0; k < 20; ++k) {
    Synthetic s = cube_with_lines(0.5, 1, draw);
    s.problem.pixels.clear();
    s.problem.points_in_target.clear();
    for (const int i : {0, 3, 6, 9}) {
      shift(s.problem.lines[static_cast<size_t>(i)], draw.uniform(8, 20));
    }
    Vector6d error = Vector6d::Zero();
    error.head<3>() = 0.25 * draw.vector().normalized();
    s.problem.initial_cam_from_target = retract(s.cam_from_target, error);
    const PoseEstimate estimate = solver("consensus").solve(s.problem);
    right += estimate.status == PoseStatus::kOk &&
             estimate.removed_lines == std::vector<int>{0, 3, 6, 9} &&
             turn_rad(estimate, s.cam_from_target) < 0.02;
  }
  EXPECT_GE(right, 18);
}

TEST(LinesInConsensus, BetweenMirrorPosesTheInitialOneDecides) {
  Draw draw(96);
  Synthetic s;
  const std::vector<Eigen::Vector3d> square = {{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0},
                                               {-0.5, 0.5, 0},  {0.2, -0.1, 0}, {0, 0.3, 0}};
  const Pose truth = {rotation_from_vector({0.3, 0.2, 0.1}), {0.1, 0, 140}};
  s = exact_problem(centred_camera(512, 512, 15000), square, truth);
  add_noise(s.problem, 1, draw);
  s.problem.sigma_px = 1;
  for (size_t i = 0; i < 4; ++i) {
    LineObservation line = exact_line(s.problem.camera, truth, {square[i], square[(i + 1) % 4]}, 5);
    add_noise(line, draw);
    s.problem.lines.push_back(line);
  }
  s.problem.initial_cam_from_target = truth;
  const PoseEstimate near_truth = solver("consensus").solve(s.problem);
  ASSERT_EQ(near_truth.status, PoseStatus::kOk);
  ASSERT_TRUE(near_truth.diagnosis->is_ambiguous.value());
  EXPECT_LT(turn_rad(near_truth, truth), 0.2);
  const Pose mirror = near_truth.second_cam_from_target.value();
  EXPECT_GT(geodesic_angle_rad(mirror.rotation, truth.rotation), 0.3);
  s.problem.initial_cam_from_target = mirror;
  const PoseEstimate near_mirror = solver("consensus").solve(s.problem);
  ASSERT_TRUE(near_mirror.diagnosis->is_ambiguous.value());
  EXPECT_LT(turn_rad(near_mirror, mirror), 0.2);
}

TEST(LinesInConsensus, NoiseThatIsUnderstatedALittleFailsTheTest) {
  Draw draw(97);
  int failed = 0;
  for (int k = 0; k < 20; ++k) {
    Synthetic s = cube_with_lines(0.8, 1.6, draw);
    s.problem.sigma_px = 0.5;
    for (LineObservation& line : s.problem.lines) line.covariance *= 0.5 * 0.5 / (0.8 * 0.8);
    const PoseEstimate estimate = solver("consensus").solve(s.problem);
    failed += estimate.diagnosis->is_test_failed.value();
  }
  EXPECT_GE(failed, 15);
}

// Somewhere between right and wrong, a point says less than nothing: whether it counts is one more
// doubt, so that the pose is known less well than without it.
TEST(LinesInConsensus, DoubtOfAnObservationWidensTheCovariance) {
  Draw draw(98);
  const Synthetic s = cube_with_lines(0.5, 2, draw);
  for (double off_px = 1; off_px < 6; off_px += 0.05) {
    PoseProblem problem = s.problem;
    problem.pixels[3].x() += off_px;
    const PoseEstimate doubtful = solver("consensus").solve(problem);
    const double probability = doubtful.inlier_probabilities.value()[3];
    if (probability < 0.4 || probability > 0.6) continue;
    problem.pixels.erase(problem.pixels.begin() + 3);
    problem.points_in_target.erase(problem.points_in_target.begin() + 3);
    const PoseEstimate without = solver("consensus").solve(problem);
    EXPECT_GT(doubtful.covariance->trace(), without.covariance->trace());
    return;
  }
  FAIL() << "no shift leaves the point in doubt";
}

// At a random attitude one of thirty edges is seen along the normal of its line: a fit that needs a
// residual of each would begin nowhere.
TEST(LinesInLeastSquares, BeginWhereSomeHaveNoResidual) {
  Draw draw(99);
  const Camera camera = centred_camera(512, 512, 15000);
  for (int k = 0; k < 3; ++k) {
    const Pose truth = cube_pose(draw);
    const PoseProblem problem = random_lines(camera, truth, 200, draw);
    const PoseEstimate estimate = solver("lspe").solve(problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk) << k;
    EXPECT_LT(turn_rad(estimate, truth), 0.01) << k;
  }
}

TEST(SolversWithoutLines, LookAtThePointsAlone) {
  Draw draw(90);
  const Synthetic s = cube_with_lines(0.5, 1, draw);
  PoseProblem points = s.problem;
  points.lines.clear();
  for (const PoseSolver& candidate : pose_solvers()) {
    if (candidate.with_lines != nullptr || candidate.evaluation_only) continue;
    const PoseEstimate with = candidate.solve(s.problem), without = candidate.solve(points);
    EXPECT_EQ(with.cam_from_target.rotation, without.cam_from_target.rotation) << candidate.name;
    EXPECT_EQ(with.cam_from_target.translation, without.cam_from_target.translation)
        << candidate.name;
  }
}

}  // namespace
}  // namespace sightline
