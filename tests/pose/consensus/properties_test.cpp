// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What consensus promises of every problem, on random ones: any number of points, any share of
// outliers, solid or planar, noise known or not.
#include <algorithm>
#include <cstring>
#include <numeric>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/pose/consensus/scenes.h"
#include "tests/pose/solvers/solving.h"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr int kDraws = 60;

/// Fits converge to 1e-7 of a radian and of the range, quadratically.
constexpr double kSameRad = 1e-6, kSameM = 1e-5;

Synthetic random_scene(Draw& draw) {
  DrawLaw law;
  law.points = 6 + draw.index(60);
  law.outliers = draw.index(law.points / 2 - 1);
  law.is_planar = draw.index(2) == 0;
  Synthetic s = scene(law, draw);
  if (draw.index(2) == 0) s.problem.sigma_px = law.sigma_px;
  return s;
}

PoseEstimate run(const PoseProblem& problem) {
  return solve("consensus", problem);
}

/// The same answer but for rounding.
void expect_same(const PoseEstimate& a, const PoseEstimate& b) {
  ASSERT_EQ(a.status, b.status);
  EXPECT_EQ(a.removed, b.removed);
  EXPECT_TRUE(is_pose_near(a.cam_from_target, b.cam_from_target, kSameRad, kSameM));
}

TEST(ConsensusProperties, SameInputSameBytes) {
  Draw draw(1);
  for (int i = 0; i < kDraws; ++i) {
    const Synthetic s = random_scene(draw);
    const PoseEstimate a = run(s.problem), b = run(s.problem);
    EXPECT_EQ(std::memcmp(&a.cam_from_target, &b.cam_from_target, sizeof(Pose)), 0);
    EXPECT_EQ(std::memcmp(&*a.covariance, &*b.covariance, sizeof(Matrix6d)), 0);
    EXPECT_EQ(a.inlier_probabilities, b.inlier_probabilities);
  }
}

TEST(ConsensusProperties, OrderOfPointsDoesNotMatter) {
  Draw draw(2);
  std::mt19937_64 engine(2);
  for (int i = 0; i < kDraws; ++i) {
    const Synthetic s = random_scene(draw);
    std::vector<int> order(s.problem.pixels.size());
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), engine);
    PoseProblem shuffled = s.problem;
    for (std::size_t k = 0; k < order.size(); ++k) {
      shuffled.points_in_target[k] = s.problem.points_in_target[order[k]];
      shuffled.pixels[k] = s.problem.pixels[order[k]];
    }
    PoseEstimate b = run(shuffled);
    for (int& k : b.removed) k = order[k];
    std::ranges::sort(b.removed);
    expect_same(b, run(s.problem));
  }
}

TEST(ConsensusProperties, NormalisedCoordinatesGiveTheSameAnswer) {
  Draw draw(3);
  for (int i = 0; i < kDraws; ++i) {
    const Synthetic s = random_scene(draw);
    PoseProblem normalised = s.problem;
    const Camera& camera = s.problem.camera;
    normalised.camera = {1, 1, 1, 1, 0, 0, 0, {}};
    normalised.sigma_px /= camera.fx_px;
    for (auto& pixel : normalised.pixels) pixel = normalised_from_pixel(camera, pixel).value();
    const PoseEstimate a = run(s.problem), b = run(normalised);
    expect_same(a, b);
    EXPECT_NEAR(*a.noise_px, camera.fx_px * *b.noise_px, 1e-5 * *a.noise_px);
    EXPECT_EQ(a.diagnosis->is_ambiguous, b.diagnosis->is_ambiguous);
    EXPECT_EQ(a.diagnosis->is_significant, b.diagnosis->is_significant);
  }
}

TEST(ConsensusProperties, PointsThatCannotBeUsedChangeNothing) {
  Draw draw(4);
  for (int i = 0; i < kDraws; ++i) {
    const Synthetic s = random_scene(draw);
    PoseProblem worse = s.problem;
    const int at = draw.index(static_cast<int>(worse.pixels.size()));
    worse.pixels.insert(worse.pixels.begin() + at,
                        Eigen::Vector2d(draw.index(2) ? kNaN : 100, kNaN));
    worse.points_in_target.insert(worse.points_in_target.begin() + at, draw.in_box(1));
    worse.points_in_target.push_back({0, kInfinity, 0});
    worse.pixels.push_back({100, 100});
    PoseEstimate b = run(worse);
    EXPECT_THAT(b.ignored, ElementsAre(at, static_cast<int>(worse.pixels.size()) - 1));
    for (int& k : b.removed) k -= k > at;
    const PoseEstimate a = run(s.problem);
    EXPECT_EQ(a.removed, b.removed);
    EXPECT_EQ(std::memcmp(&a.cam_from_target, &b.cam_from_target, sizeof(Pose)), 0);
  }
}

TEST(ConsensusProperties, CovariancesThatAreNoneLeaveTheirPointsOut) {
  Draw draw(5);
  const Synthetic s = scene({12, 0, false, 1}, draw);
  PoseProblem problem = s.problem;
  problem.covariances_px2.assign(12, Eigen::Matrix2d::Identity());
  EXPECT_THAT(run(problem).ignored, IsEmpty());
  problem.covariances_px2[3].setZero();
  problem.covariances_px2[7] << 1, 2, 2, 1;  // indefinite
  problem.covariances_px2[9](0, 0) = kNaN;
  const PoseEstimate estimate = run(problem);
  ASSERT_EQ(estimate.status, PoseStatus::kOk);
  EXPECT_THAT(estimate.ignored, ElementsAre(3, 7, 9));
  for (auto& covariance : problem.covariances_px2) covariance.setZero();
  EXPECT_EQ(run(problem).status, PoseStatus::kDegenerate);
}

TEST(ConsensusProperties, EqualCovariancesAreNoiseThatIsKnown) {
  Draw draw(6);
  for (int i = 0; i < kDraws; ++i) {
    Synthetic s = random_scene(draw);
    s.problem.sigma_px = 1;
    PoseProblem whitened = s.problem;
    whitened.sigma_px = 0;
    whitened.covariances_px2.assign(s.problem.pixels.size(), Eigen::Matrix2d::Identity());
    expect_same(run(whitened), run(s.problem));
  }
}

TEST(ConsensusProperties, PreciseAndVaguePixelsCountAsSuch) {
  Draw draw(7);
  constexpr double kVague = 20;
  for (int i = 0; i < kDraws; ++i) {
    Synthetic s = scene({20, 0, false, 0.1}, draw);
    for (int k = 0; k < 10; ++k) s.problem.pixels[k] += draw.pixel_noise(kVague);
    PoseProblem precise = s.problem;
    precise.points_in_target.erase(precise.points_in_target.begin(),
                                   precise.points_in_target.begin() + 10);
    precise.pixels.erase(precise.pixels.begin(), precise.pixels.begin() + 10);
    precise.sigma_px = 0.1;
    s.problem.covariances_px2.assign(20, 0.01 * Eigen::Matrix2d::Identity());
    for (int k = 0; k < 10; ++k) s.problem.covariances_px2[k] *= 1e4 * kVague * kVague / 100;
    const PoseEstimate a = run(s.problem), b = run(precise);
    ASSERT_EQ(a.status, PoseStatus::kOk);
    const Vector6d apart = change_between(b.cam_from_target, a.cam_from_target);
    // Vague points add a part in 1e4 of the information: a hundredth of a standard deviation.
    EXPECT_LT(apart.dot(b.covariance->ldlt().solve(apart)), 0.1);
  }
}

TEST(ConsensusProperties, InitialPoseCanOnlyHelp) {
  Draw draw(8);
  int choices = 0;
  for (int i = 0; i < kDraws; ++i) {
    const Synthetic s = random_scene(draw);
    const PoseEstimate free = run(s.problem);
    PoseProblem started = s.problem;
    for (const Pose& initial :
         {Pose{draw.rotation(), {0, 0, 6}}, Pose{draw.rotation(), {1, 2, -6}},
          Pose{2 * draw.rotation(), {0, 0, 6}}, Pose{draw.rotation(), {0, kNaN, 6}}}) {
      started.initial_cam_from_target = initial;
      PoseEstimate helped = run(started);
      const bool is_choice = free.second_cam_from_target && helped.second_cam_from_target;
      const auto is_of_free = [&free](const Pose& pose) {
        return is_pose_near(pose, free.cam_from_target, kSameRad, kSameM);
      };
      if (!is_choice || is_of_free(helped.cam_from_target)) {
        expect_same(helped, free);
        continue;
      }
      // Of two poses that both are probable it says which.
      EXPECT_TRUE(is_of_free(*helped.second_cam_from_target));
      ++choices;
    }
  }
  EXPECT_LE(choices, 4);
}

/// Of a plane from afar, whose two poses are about alike probable.
TEST(ConsensusProperties, InitialPoseDecidesBetweenTwoPoses) {
  Draw draw(18);
  int helped = 0;
  for (int i = 0; i < 10; ++i) {
    const Pose truth = {rotation_from_vector({0.6, 0.2, 0.1}), {0.1, 0.2, 500}};
    Synthetic s =
        exact_problem(centred_camera(640, 480, 50000), points_in_box(8, {1, 1, 0}, draw), truth);
    add_noise(s.problem, 1, draw);
    s.problem.sigma_px = 1;
    const auto is_right = [&s](const PoseEstimate& estimate) {
      return geodesic_angle_rad(estimate.cam_from_target.rotation, s.cam_from_target.rotation) <
             0.3;
    };
    helped += !is_right(run(s.problem));
    s.problem.initial_cam_from_target =
        Pose{draw.rotation_by(0.05) * truth.rotation, truth.translation};
    const PoseEstimate estimate = run(s.problem);
    EXPECT_TRUE(is_right(estimate));
    EXPECT_TRUE(is_ambiguous(estimate));
  }
  EXPECT_GT(helped, 0);
}

/// Noise that was stated a tenth of what it is, each point's its own: no pose agrees with that.
TEST(ConsensusProperties, UnderstatedNoiseLeavesAPoseThatSaysSo) {
  Draw draw(19);
  int alarms = 0;  // of noise as stated: one of a hundred
  for (const bool has_initial : {false, true}) {
    for (int i = 0; i < 10; ++i) {
      Synthetic s = scene({5, 0, false, 2}, draw);
      s.problem.covariances_px2.assign(5, 0.0004 * Eigen::Matrix2d::Identity());
      if (has_initial) {
        s.problem.initial_cam_from_target = Pose{
            draw.rotation_by(0.05) * s.cam_from_target.rotation, s.cam_from_target.translation};
      }
      const PoseEstimate estimate = run(s.problem);
      ASSERT_EQ(estimate.status, PoseStatus::kOk);
      EXPECT_TRUE(is_test_failed(estimate));
      EXPECT_GT(estimate.noise_px.value(), 1);
      EXPECT_TRUE(is_free_of_nan(estimate));
      s.problem.covariances_px2.assign(5, 4 * Eigen::Matrix2d::Identity());
      alarms += is_test_failed(run(s.problem));
    }
  }
  EXPECT_LE(alarms, 3);
}

TEST(ConsensusProperties, RoundedRotationIsAStart) {
  Draw draw(9);
  for (int i = 0; i < kDraws; ++i) {
    const Synthetic s = scene({6, 0, false, 0}, draw);
    PoseProblem three = first_points(s.problem, 3);
    three.initial_cam_from_target = s.cam_from_target;
    Eigen::Matrix3d& rotation = three.initial_cam_from_target->rotation;
    rotation = (1e4 * rotation).array().round() / 1e4;
    const PoseEstimate estimate = run(three);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    EXPECT_TRUE(is_pose_near(estimate.cam_from_target, s.cam_from_target, 1e-4, 1e-3));
    rotation *= 1.1;
    EXPECT_EQ(run(three).status, PoseStatus::kDegenerate);
  }
}

TEST(ConsensusProperties, MirrorPoseOfAFarPlaneIsTheSecond) {
  Draw draw(10);
  int second_is_right = 0, ambiguous = 0;
  for (int i = 0; i < kDraws; ++i) {
    const Pose pose = {draw.rotation_by(0.5), Eigen::Vector3d(0.2, 0.1, 200)};
    Synthetic s =
        exact_problem(centred_camera(640, 480, 20000), points_in_box(12, {1, 1, 0}, draw), pose);
    add_noise(s.problem, 1, draw);
    s.problem.sigma_px = 1;
    for (const bool has_initial : {false, true}) {
      if (has_initial) s.problem.initial_cam_from_target = s.cam_from_target;
      const PoseEstimate estimate = run(s.problem);
      ASSERT_EQ(estimate.status, PoseStatus::kOk);
      EXPECT_EQ(is_ambiguous(estimate), estimate.second_cam_from_target.has_value());
      if (!is_ambiguous(estimate)) continue;
      ++ambiguous;
      const double first = squared_distance_from_truth(estimate.cam_from_target, s, 1);
      const double second = squared_distance_from_truth(*estimate.second_cam_from_target, s, 1);
      second_is_right += first > 60 && second < 60;
      EXPECT_LT(std::min(first, second), 60);
    }
  }
  EXPECT_GT(ambiguous, kDraws / 2);
  EXPECT_GT(second_is_right, 0);
}

/// A target that is solid, but so thin in the image that its mirror pose may fit as well.
TEST(ConsensusProperties, WrongPoseOfAThinTargetIsFlagged) {
  Draw draw(20);
  int ambiguous = 0, wrong = 0;
  for (int i = 0; i < 5 * kDraws; ++i) {
    const Pose pose = {draw.rotation_by(0.5), Eigen::Vector3d(0.2, 0.1, 1500)};
    Synthetic s =
        exact_problem(centred_camera(640, 480, 20000), points_in_box(8, {1, 1, 0.25}, draw), pose);
    add_noise(s.problem, 1, draw);
    s.problem.sigma_px = 1;
    const PoseEstimate estimate = run(s.problem);
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    ambiguous += is_ambiguous(estimate);
    wrong +=
        !is_ambiguous(estimate) && squared_distance_from_truth(estimate.cam_from_target, s, 1) > 60;
  }
  EXPECT_GT(ambiguous, kDraws / 3);
  // The whole search leaves two unflagged; answered without a look at the mirror pose, eleven are.
  EXPECT_LE(wrong, 3);
}

/// Of the points of a mirrored target some lie near a plane, which is its own mirror image: they do
/// agree on a pose, and where they are many that is no chance.
TEST(ConsensusProperties, MirroredTargetIsSeldomSignificant) {
  Draw draw(11);
  int significant = 0;
  for (int i = 0; i < kDraws; ++i) {
    Synthetic s = scene({20, 0, false, 1}, draw);
    s.problem.sigma_px = 1;
    EXPECT_TRUE(run(s.problem).diagnosis.value().is_significant.value());
    for (auto& x : s.problem.points_in_target) x.x() *= -1;
    const PoseEstimate mirrored = run(s.problem);
    significant += mirrored.status == PoseStatus::kOk && *mirrored.diagnosis->is_significant;
  }
  EXPECT_LT(significant, kDraws / 4);
}

TEST(ConsensusProperties, RandomPixelsAreNotSignificant) {
  Draw draw(13);
  int significant = 0;
  for (int i = 0; i < kDraws / 3; ++i) {
    Synthetic s = scene({5 + draw.index(60), 0, i % 2 == 0, 1}, draw);
    s.problem.sigma_px = draw.index(2);
    for (auto& pixel : s.problem.pixels) pixel = {draw.uniform(0, 639), draw.uniform(0, 479)};
    const PoseEstimate estimate = run(s.problem);
    significant += estimate.status == PoseStatus::kOk && *estimate.diagnosis->is_significant;
  }
  EXPECT_LE(significant, 1);
}

TEST(ConsensusProperties, FarPointsAreOutliersLikeAnyOther) {
  Draw draw(12);
  for (const double far : {1e3, 1e6, 1e12, 1e40}) {
    const Synthetic s = scene({12, 0, false, 0}, draw);
    PoseProblem worse = s.problem;
    worse.points_in_target[4] *= far;
    const PoseEstimate estimate = run(worse);
    ASSERT_EQ(estimate.status, PoseStatus::kOk) << far;
    EXPECT_THAT(estimate.removed, ElementsAre(4)) << far;
    EXPECT_TRUE(is_pose_near(estimate.cam_from_target, s.cam_from_target, 1e-9, 1e-8)) << far;
  }
}

}  // namespace
}  // namespace sightline
