// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: Apache-2.0
#include "pose/minimax.h"

#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include "pose/reprojection.h"
#include "tests/pose/matchers.h"
#include "tests/pose/synthetic.h"

namespace sightline {
namespace {

constexpr double kSupportMultiplier = 1e-6;

/// A noisy cube, with an outlier in every second one.
Correspondences cube(int i, double sigma_px, Draw& draw) {
  Synthetic s = cube_problem(sigma_px, draw);
  if (i % 2) add_outlier(s.problem, draw.index(8), draw.uniform(15, 30), draw);
  return prepare(s.problem).correspondences;
}

Minimax fit(const FitPoints& points) {
  return minimax(points, starting_poses(points.correspondences, std::nullopt), {});
}

double largest_px2(const Correspondences& c, const Pose& pose) {
  double largest = 0;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const auto r = residual_px(c, i, pose);
    largest = std::max(largest, r ? r->squaredNorm() : kInfinity);
  }
  return largest;
}

TEST(Minimax, IsProvenByItsMultipliers) {
  Draw draw(1);
  for (int i = 0; i < 200; ++i) {
    const Correspondences c = cube(i, draw.uniform(0.1, 4), draw);
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
    const Correspondences c = cube(i, 1, draw);
    const Minimax m = fit({c, {}, {}});
    const std::vector<double> even(8, 1.0 / 8);
    const LeastSquares bound = least_squares(c, {&m.cam_from_centred, 1}, {}, even);
    EXPECT_LT(bound.cost_px2, 0.99 * m.largest_px2);
  }
}

TEST(Minimax, NoPerturbationLowersIt) {
  Draw draw(3);
  for (int i = 0; i < 20; ++i) {
    const Correspondences c = cube(i, 1, draw);
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
    const Correspondences c = cube(i, 1, draw);
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
    const Correspondences c = cube(i, 1, draw);
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

TEST(FitPoints, WhiteningMultipliesResidualAndJacobian) {
  Draw draw(12);
  const Correspondences c = cube(0, 1, draw);
  std::vector<Eigen::Matrix2d> whitening(8, Eigen::Matrix2d::Identity());
  whitening[3] << 2, 0.5, 0, 3;
  const std::vector<int> kept = {1, 3};
  const FitPoints points = {c, kept, whitening};
  const Pose pose = starting_poses(c, std::nullopt).front();
  const auto plain = reproject(c, 3, pose);
  const auto whitened = reproject(points, 1, pose);
  ASSERT_TRUE(plain && whitened);
  EXPECT_EQ(points.size(), 2u);
  EXPECT_TRUE(is_matrix_near(whitened->residual_px, whitening[3] * plain->residual_px, 1e-12));
  EXPECT_TRUE(is_matrix_near(whitened->jacobian, whitening[3] * plain->jacobian, 1e-9));
}

TEST(FitPoints, WhiteningByANumberScalesTheMinimaxAndMovesNothing) {
  Draw draw(13);
  const Correspondences c = cube(1, 1, draw);
  const std::vector<Eigen::Matrix2d> thirds(8, Eigen::Matrix2d::Identity() / 3);
  const Minimax plain = fit({c, {}, {}});
  const Minimax scaled = fit({c, {}, thirds});
  ASSERT_EQ(scaled.status, PoseStatus::kOk);
  EXPECT_NEAR(9 * scaled.largest_px2, plain.largest_px2, 1e-6 * plain.largest_px2);
  EXPECT_TRUE(is_pose_near(scaled.cam_from_centred, plain.cam_from_centred, 1e-6, 1e-4));
}

TEST(FitPoints, LeastSquaresWeighsByTheWhiteningAsItIs) {
  // Not symmetric: its square in the cost is the transposed times itself, not itself twice.
  Draw draw(15);
  const Correspondences c = cube(0, 1, draw);
  std::vector<Eigen::Matrix2d> whitening(8);
  for (int i = 0; i < 8; ++i) whitening[i] << 2, 1.5 - 0.3 * i, 0, 1;
  const FitPoints points = {c, {}, whitening};
  const LeastSquares fit = least_squares(points, starting_poses(c, std::nullopt), {});
  ASSERT_EQ(fit.status, PoseStatus::kOk);
  double cost_px2 = 0;
  Vector6d gradient = Vector6d::Zero();
  double scale = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto r = reproject(points, i, fit.cam_from_centred);
    ASSERT_TRUE(r);
    cost_px2 += r->residual_px.squaredNorm();
    gradient += r->jacobian.transpose() * r->residual_px;
    scale += r->jacobian.norm() * r->residual_px.norm();
  }
  EXPECT_NEAR(fit.cost_px2, cost_px2, 1e-9 * cost_px2);
  EXPECT_LT(gradient.norm(), 1e-6 * scale);
}

TEST(FitPoints, LeastSquaresLeavesOutWhatIsNotKept) {
  Draw draw(14);
  Synthetic s = cube_problem(1, draw);
  add_outlier(s.problem, 5, 30, draw);
  const Correspondences c = prepare(s.problem).correspondences;
  const std::vector<Pose> starts = starting_poses(c, std::nullopt);
  const std::vector<int> kept = {0, 1, 2, 3, 4, 6, 7};
  const std::vector<Eigen::Matrix2d> ones(8, Eigen::Matrix2d::Identity());
  const LeastSquares expected = least_squares(without(c, 5), starts, {});
  for (const LeastSquares& actual :
       {least_squares({c, kept, {}}, starts, {}), least_squares({c, kept, ones}, starts, {})}) {
    ASSERT_EQ(actual.status, PoseStatus::kOk);
    EXPECT_TRUE(is_pose_near(actual.cam_from_centred, expected.cam_from_centred, 1e-8, 1e-6));
    EXPECT_NEAR(actual.cost_px2, expected.cost_px2, 1e-9 * expected.cost_px2);
    EXPECT_TRUE(is_matrix_near(actual.unit_covariance, expected.unit_covariance,
                               1e-6 * expected.unit_covariance.norm()));
  }
}

TEST(RemovalLimit, LeavesAMajorityAndTwoRedundantCoordinates) {
  const OutlierOptions unsaid;
  const std::vector<std::size_t> expected = {0, 0, 0, 0, 0, 1, 2, 3, 3, 4, 4, 5, 5};
  for (std::size_t n = 0; n < expected.size(); ++n)
    EXPECT_EQ(minority_limit(n, unsaid), expected[n]);

  OutlierOptions said;
  said.max_removed = 6;
  EXPECT_EQ(minority_limit(12, said), 6u);
  EXPECT_EQ(minority_limit(8, said), 4u);
  EXPECT_EQ(minority_limit(3, said), 0u);
  said.max_removed = 0;
  EXPECT_EQ(minority_limit(8, said), 0u);
  said.max_removed = -1;
  EXPECT_EQ(minority_limit(8, said), 0u);
}

// The solver

TEST(MinimaxSolver, HasASmallerMaximumThanLeastSquaresAndALargerSum) {
  Draw draw(15);
  for (int i = 0; i < 50; ++i) {
    const PoseProblem problem = cube_problem(1, draw).problem;
    const PoseEstimate estimate = find_pose_solver("minimax")->solve(problem, {});
    const PoseEstimate lspe = find_pose_solver("lspe")->solve(problem, {});
    ASSERT_EQ(estimate.status, PoseStatus::kOk);
    EXPECT_TRUE(estimate.removed.empty());
    const Correspondences c = prepare(problem).correspondences;
    const Pose pose = to_centred(estimate.cam_from_target, c);
    const Pose lspe_pose = to_centred(lspe.cam_from_target, c);
    EXPECT_LT(largest_px2(c, pose), largest_px2(c, lspe_pose));
    double sum = 0, lspe_sum = 0;
    for (std::size_t k = 0; k < 8; ++k) {
      sum += residual_px(c, k, pose)->squaredNorm();
      lspe_sum += residual_px(c, k, lspe_pose)->squaredNorm();
    }
    EXPECT_GT(sum, lspe_sum);
  }
}

TEST(MinimaxSolver, IsTheLimitOfTheEntropyFunction) {
  Draw draw(16);
  SolverOptions keep_all;
  keep_all.orpe.rho = kInfinity;
  for (int i = 0; i < 50; ++i) {
    Synthetic s = cube_problem(1, draw);
    if (i % 2) add_outlier(s.problem, 0, 20, draw);
    const Correspondences c = prepare(s.problem).correspondences;
    const auto largest = [&](std::string_view name) {
      const PoseEstimate e = find_pose_solver(name)->solve(s.problem, keep_all);
      return largest_px2(c, to_centred(e.cam_from_target, c));
    };
    EXPECT_LE(largest("minimax"), largest("orpe") * (1 + kMinimaxGap));
    EXPECT_LE(largest("orpe"), largest("minimax") * (1 + 1.1 * std::log(8.0) / 512));
  }
}

}  // namespace
}  // namespace sightline
