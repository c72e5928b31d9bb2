// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/minimax.h"

#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include "pose/least_squares.h"
#include "pose/reprojection.h"
#include "pose/starts.h"
#include "tests/pose/matchers.h"
#include "tests/pose/solvers/solving.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

constexpr double kSupportMultiplier = 1e-6;

Minimax fit(const FitPoints& points) {
  return minimax(points, starting_poses(points.correspondences, std::nullopt), {});
}

TEST(Minimax, IsProvenByItsMultipliers) {
  Draw draw(1);
  for (int i = 0; i < 200; ++i) {
    const Correspondences c = noisy_cube(i, draw.uniform(0.1, 4), draw);
    const Minimax m = fit({c, {}, {}});
    ASSERT_EQ(m.status, PoseStatus::kOk);
    EXPECT_LE(m.relative_gap, kMinimaxGap);
    EXPECT_NEAR(m.largest_px2, largest_px2(c, m.cam_from_centred), 1e-12 * m.largest_px2);
    EXPECT_GE(*std::min_element(m.multipliers.begin(), m.multipliers.end()), 0);
    EXPECT_NEAR(std::accumulate(m.multipliers.begin(), m.multipliers.end(), 0.0), 1, 1e-12);
    // The dual bound, here not of linearised residuals but by least squares to its end.
    const LeastSquares bound = least_squares(c, {&m.cam_from_centred, 1}, {}, m.multipliers);
    EXPECT_GE(bound.cost_px2, m.largest_px2 * (1 - 2 * kMinimaxGap));
    EXPECT_LE(bound.cost_px2, m.largest_px2 * (1 + 1e-12));
  }
}

TEST(Minimax, OtherWeightsProveLess) {
  Draw draw(2);
  for (int i = 0; i < 20; ++i) {
    const Correspondences c = noisy_cube(i, 1, draw);
    const Minimax m = fit({c, {}, {}});
    const std::vector<double> even(8, 1.0 / 8);
    const LeastSquares bound = least_squares(c, {&m.cam_from_centred, 1}, {}, even);
    EXPECT_LT(bound.cost_px2, 0.99 * m.largest_px2);
  }
}

TEST(Minimax, NoPerturbationLowersIt) {
  Draw draw(3);
  for (int i = 0; i < 20; ++i) {
    const Correspondences c = noisy_cube(i, 1, draw);
    const Minimax m = fit({c, {}, {}});
    for (int k = 0; k < 500; ++k) {
      const double size = std::pow(10, draw.uniform(-6, 0));
      Vector6d delta;
      delta << size * draw.vector(),
          size * 0.1 * m.cam_from_centred.translation.norm() * draw.vector();
      EXPECT_GE(largest_px2(c, retract(m.cam_from_centred, delta)),
                m.largest_px2 * (1 - kMinimaxGap));
    }
  }
}

TEST(Minimax, TheSupportAloneHasIt) {
  Draw draw(4);
  for (int i = 0; i < 50; ++i) {
    const Correspondences c = noisy_cube(i, 1, draw);
    const Minimax all = fit({c, {}, {}});
    std::vector<int> support;
    for (int k = 0; k < 8; ++k) {
      if (all.multipliers[static_cast<std::size_t>(k)] > kSupportMultiplier) support.push_back(k);
    }
    const Minimax alone = minimax_from({c, support, {}}, all.cam_from_centred);
    ASSERT_EQ(alone.status, PoseStatus::kOk);
    EXPECT_NEAR(alone.largest_px2, all.largest_px2, 2 * kMinimaxGap * all.largest_px2);

    // Without one of its points the maximum falls.
    std::vector<int> kept(8);
    std::iota(kept.begin(), kept.end(), 0);
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(all.most_binding()));
    const Minimax less = minimax_from({c, kept, {}}, all.cam_from_centred);
    EXPECT_LT(less.largest_px2, all.largest_px2 * (1 - 10 * kMinimaxGap));
  }
}

TEST(Minimax, TheLargestMultiplierIsTheOutlier) {
  constexpr int kTrials = 200;
  Draw draw(5);
  int found = 0;
  for (int i = 0; i < kTrials; ++i) {
    Synthetic s = cube_problem(1, draw);
    const int outlier = draw.index(8);
    add_outlier(s.problem, outlier, draw.uniform(15, 30), draw);
    const Correspondences c = prepare(s.problem).correspondences;
    found += fit({c, {}, {}}).most_binding() == static_cast<std::size_t>(outlier);
  }
  EXPECT_GE(found, 0.98 * kTrials);
}

TEST(Minimax, ExactDataAreZeroAndNoisyOnesAreNot) {
  Draw draw(6);
  for (int i = 0; i < 20; ++i) {
    for (const double sigma_px : {0.0, 1e-5, 1e-3}) {
      const Correspondences c = prepare(cube_problem(sigma_px, draw).problem).correspondences;
      const Minimax m = fit({c, {}, {}});
      ASSERT_EQ(m.status, PoseStatus::kOk);
      EXPECT_EQ(m.largest_px2 > 0, sigma_px > 0);
      EXPECT_LE(m.relative_gap, kMinimaxGap);
    }
  }
}

// The iteration has no line search: this is what says that it needs none.
TEST(Minimax, ConvergesWhateverThePoints) {
  Draw draw(7);
  for (int i = 0; i < 3000; ++i) {
    std::vector<Eigen::Vector3d> points;
    const int n = 4 + draw.index(9);
    const Eigen::Vector3d half_width(1, 1, i % 3 ? 1.0 : 0.01);
    for (int k = 0; k < n; ++k) points.push_back(half_width.cwiseProduct(draw.in_box(1)));
    Synthetic s = exact_problem(centred_camera(640, 480, 800), points,
                                {draw.rotation(), {0.4, -0.3, draw.uniform(4, 40)}});
    add_noise(s.problem, draw.uniform(0, 2), draw);
    if (i % 2) add_outlier(s.problem, 0, 30, draw);
    const Correspondences c = prepare(s.problem).correspondences;
    const Minimax m = minimax_from({c, {}, {}}, to_centred(s.cam_from_target, c));
    EXPECT_EQ(m.status, PoseStatus::kOk) << "draw " << i << ", gap " << m.relative_gap;
  }
}

TEST(Minimax, BothMirrorStartsAreCarriedToTheEnd) {
  Draw draw(8);
  for (int i = 0; i < 100; ++i) {
    Synthetic s = exact_problem(centred_camera(512, 512, 3000),
                                {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0.3, 0.5, 0}},
                                {draw.rotation(), {0, 0, 30}});
    add_noise(s.problem, 0.5, draw);
    const Correspondences c = prepare(s.problem).correspondences;
    const Minimax both = fit({c, {}, {}});
    const Minimax near_truth = minimax_from({c, {}, {}}, to_centred(s.cam_from_target, c));
    ASSERT_EQ(both.status, PoseStatus::kOk);
    EXPECT_LE(both.largest_px2, near_truth.largest_px2 * (1 + 2 * kMinimaxGap));
  }
}

TEST(Minimax, StartBehindTheCameraSaysSo) {
  Draw draw(9);
  const Synthetic s = cube_problem(1, draw);
  const Correspondences c = prepare(s.problem).correspondences;
  Pose start = to_centred(s.cam_from_target, c);
  EXPECT_EQ(minimax_from({c, {}, {}}, start).status, PoseStatus::kOk);
  start.translation.z() *= -1;
  EXPECT_EQ(minimax_from({c, {}, {}}, start).status, PoseStatus::kBehindCamera);
  EXPECT_EQ(minimax({c, {}, {}}, {&start, 1}, {}).status, PoseStatus::kBehindCamera);
  EXPECT_EQ(minimax({c, {}, {}}, {}, {}).status, PoseStatus::kDegenerate);
}

TEST(Minimax, NumbersThatOverflowGiveNoNaN) {
  Draw draw(10);
  for (const double size : {1e100, 1e160, 1e300}) {
    Synthetic s = cube_problem(1, draw);
    s.problem.pixels[2].x() = size;
    const Correspondences c = prepare(s.problem).correspondences;
    const Minimax m = minimax_from({c, {}, {}}, to_centred(s.cam_from_target, c));
    EXPECT_TRUE(is_valid(m.cam_from_centred));
    EXPECT_FALSE(std::isnan(m.largest_px2));
    EXPECT_FALSE(std::isnan(m.relative_gap));
    for (const double l : m.multipliers) EXPECT_FALSE(std::isnan(l));
  }
}

TEST(Minimax, OnlyTheFreePartMoves) {
  Draw draw(11);
  for (int i = 0; i < 20; ++i) {
    const Correspondences c = noisy_cube(i, 1, draw);
    const std::vector<Pose> starts = starting_poses(c, std::nullopt);
    const Pose begin = least_squares(c, starts, {}).cam_from_centred;
    const double joint = minimax_from({c, {}, {}}, begin).largest_px2;
    MinimaxOptions options;
    options.free = FreePart::kTranslation;
    const Minimax moved = minimax_from({c, {}, {}}, begin, options);
    ASSERT_EQ(moved.status, PoseStatus::kOk);
    EXPECT_TRUE(is_matrix_near(moved.cam_from_centred.rotation, begin.rotation, kRotationRounding));
    options.free = FreePart::kRotation;
    const Minimax turned = minimax_from({c, {}, {}}, begin, options);
    ASSERT_EQ(turned.status, PoseStatus::kOk);
    EXPECT_EQ(turned.cam_from_centred.translation, begin.translation);
    for (const Minimax& part : {moved, turned}) {
      EXPECT_LT(part.largest_px2, largest_px2(c, begin));
      EXPECT_GT(part.largest_px2, joint);
    }
  }
}

TEST(FitPoints, WhiteningByANumberScalesTheMinimaxAndMovesNothing) {
  Draw draw(13);
  const Correspondences c = noisy_cube(1, 1, draw);
  const std::vector<Eigen::Matrix2d> thirds(8, Eigen::Matrix2d::Identity() / 3);
  const Minimax plain = fit({c, {}, {}});
  const Minimax scaled = fit({c, {}, thirds});
  ASSERT_EQ(scaled.status, PoseStatus::kOk);
  EXPECT_NEAR(9 * scaled.largest_px2, plain.largest_px2, 1e-6 * plain.largest_px2);
  EXPECT_TRUE(is_pose_near(scaled.cam_from_centred, plain.cam_from_centred, 1e-6, 1e-4));
}

}  // namespace
}  // namespace sightline
