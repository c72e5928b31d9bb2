// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The parts of consensus against plain versions of themselves.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "pose/consensus/cloud.h"
#include "pose/consensus/mixture.h"
#include "pose/consensus/modes.h"
#include "pose/consensus/noise.h"
#include "pose/consensus/score.h"
#include "pose/consensus/search.h"
#include "tests/pose/consensus/scenes.h"
#include "tests/pose/solvers/solving.h"

namespace sightline::consensus {
namespace {

Cloud cloud_of_scene(const Synthetic& s) {
  PreparedCloud prepared = prepare_cloud(s.problem);
  EXPECT_EQ(prepared.status, PoseStatus::kOk);
  return prepared.cloud;
}

TEST(ConsensusCloud, ResidualsAreThoseOfTheProblem) {
  Draw draw(1);
  const Synthetic s = scene({20, 5, false, 1}, draw);
  const Cloud cloud = cloud_of_scene(s);
  const Pose pose = to_cloud(s.cam_from_target, cloud);
  EXPECT_TRUE(is_pose_near(from_cloud(pose, cloud), s.cam_from_target, 1e-12, 1e-12));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Row row;
    ASSERT_TRUE(row_at(cloud, pose, i, row));
    const double expected_px2 =
        squared_error_px2(s.problem, cloud.given_index[i], s.cam_from_target);
    const double unit2 = cloud.image_unit_px * cloud.image_unit_px;
    EXPECT_NEAR(row.squared() * unit2, expected_px2, 1e-9 * (1 + expected_px2));
  }
}

TEST(ConsensusCloud, RowsAreDerivatives) {
  Draw draw(2);
  Synthetic s = scene({10, 0, false, 1}, draw);
  for (int i = 0; i < 10; ++i) {
    s.problem.covariances_px2.emplace_back((Eigen::Matrix2d() << 2, 0.5, 0.5, 1).finished());
  }
  const Cloud cloud = cloud_of_scene(s);
  const Pose pose = to_cloud(s.cam_from_target, cloud);
  constexpr double kStep = 1e-6;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Row row;
    ASSERT_TRUE(row_at(cloud, pose, i, row));
    for (int k = 0; k < 6; ++k) {
      double after[2], before[2];
      residual_at(cloud, retract(pose, kStep * Vector6d::Unit(k)), i, after);
      residual_at(cloud, retract(pose, -kStep * Vector6d::Unit(k)), i, before);
      for (int half = 0; half < 2; ++half) {
        // Whitened residuals are some hundred an image; second differences err by 1e-6 of them.
        EXPECT_NEAR(row.jacobian[half][k], (after[half] - before[half]) / (2 * kStep), 1e-2);
      }
    }
  }
}

TEST(ConsensusCloud, InitialPosesAreMadeRigidAndRigidOnesLeftAsTheyAre) {
  Pose exact;
  exact.rotation = rotation_from_vector({0.3, -1.1, 0.7});
  exact.translation = {0.1, 0.2, 5};
  Pose rounded = exact;
  rounded.rotation = (exact.rotation * 1e4).array().round() / 1e4;
  const auto off = [](const Pose& pose) {
    return (pose.rotation.transpose() * pose.rotation - Eigen::Matrix3d::Identity()).norm();
  };
  EXPECT_GT(off(rounded), 1e-5);
  const Pose rigid = rigid_pose(rounded).value();
  EXPECT_LT(off(rigid), 1e-14);
  EXPECT_LT(geodesic_angle_rad(rigid.rotation, exact.rotation), 1e-4);
  EXPECT_LT((rigid_pose(exact).value().rotation - exact.rotation).norm(), 1e-15);
  exact.rotation *= 1.02;
  EXPECT_FALSE(rigid_pose(exact));
}

TEST(ConsensusKernel, CountsWhatDistancesSay) {
  Draw draw(3);
  const Synthetic s = scene({101, 50, false, 1}, draw);
  const Cloud cloud = cloud_of_scene(s);
  const kernel::ScreenPose pose = screen_pose(cloud, to_cloud(s.cam_from_target, cloud));
  const std::size_t padded = cloud.screen.padded();
  ASSERT_EQ(padded, 104u);
  std::vector<float> distances2(padded);
  kernel::squared_distances(cloud.screen, pose, padded, distances2.data());
  for (const double radius_px : {1.0, 3.0, 30.0}) {
    const double radius = radius_px / cloud.image_unit_px;
    int expected = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const double error_px2 =
          squared_error_px2(s.problem, cloud.given_index[i], s.cam_from_target);
      expected += error_px2 <= radius_px * radius_px;
    }
    const int count =
        kernel::count_within(cloud.screen, pose, 0, padded, static_cast<float>(radius * radius));
    EXPECT_EQ(count, expected);
    EXPECT_GT(count, 0);
  }
}

TEST(ConsensusKernel, SeesNothingBehindTheCamera) {
  Draw draw(4);
  const Cloud cloud = cloud_of_scene(scene({16, 0, false, 0}, draw));
  const Pose behind = {Eigen::Matrix3d::Identity(), {0, 0, -100}};
  const kernel::ScreenPose pose = screen_pose(cloud, behind);
  EXPECT_EQ(kernel::count_within(cloud.screen, pose, 0, 16, 1e20F), 0);
  std::vector<float> distances2(16);
  kernel::squared_distances(cloud.screen, pose, 16, distances2.data());
  for (const float d2 : distances2) EXPECT_EQ(d2, kernel::kNotSeen);
}

TEST(ConsensusNoise, EvidenceIsThatOfASum) {
  for (const double pairs : {1.0, 2.0, 5.0, 50.0}) {
    for (const double sigma : {1e-5, 1e-3, 2e-2}) {
      const double squares = 2 * pairs * sigma * sigma;
      const double centre = std::log(kTypicalNoise);
      double integral = 0, moment = 0, mode = 0, highest = 0;
      constexpr double kStep = 1e-3;
      for (double x = centre - 12; x < centre + 8; x += kStep) {
        const double doubt = x > centre ? kLargerNoiseDoubt : kSmallerNoiseDoubt;
        const double z = (x - centre) / doubt;
        // Relative to the noise's own size, so that nothing overflows.
        const double height = std::exp(-2 * pairs * (x - std::log(sigma)) + pairs -
                                       0.5 * squares * std::exp(-2 * x) - 0.5 * z * z);
        integral += kStep * height;
        moment += kStep * height * std::exp(2 * x);
        if (height > highest) highest = height, mode = x;
      }
      const NoisePosterior posterior = noise_posterior(squares, pairs);
      EXPECT_NEAR(0.5 * std::log(posterior.most_probable), mode, 2 * kStep);
      // Laplace's error is of the order of 1 / (12 nu).
      const double expected = std::log(integral) - 2 * pairs * std::log(sigma) - pairs;
      EXPECT_NEAR(posterior.log_evidence, expected, 0.2);
      const double mean = mean_variance(squares, pairs);
      EXPECT_NEAR(mean, moment / integral, 0.01 * mean);
    }
  }
}

TEST(ConsensusScore, TruthBeatsPosesNearAndFar) {
  Draw draw(5);
  for (const double sigma_px : {0.0, 1.0}) {
    Synthetic s = scene({40, 20, false, 1}, draw);
    s.problem.sigma_px = sigma_px;
    const Cloud cloud = cloud_of_scene(s);
    Scorer scorer(cloud);
    const Pose truth = to_cloud(s.cam_from_target, cloud);
    const double best = scorer.score(truth).total;
    for (int i = 0; i < 20; ++i) {
      Pose other = truth;
      other.rotation = draw.rotation_by(i % 2 ? 0.05 : 1) * other.rotation;
      EXPECT_LT(scorer.score(other).total, best);
    }
    EXPECT_GT(scorer.log_improbability(truth), 50);
  }
}

TEST(ConsensusMixture, FindsTheNoiseAndTheOutliers) {
  Draw draw(6);
  for (const double sigma_px : {0.1, 1.0, 5.0}) {
    const Synthetic s = scene({200, 100, false, sigma_px}, draw);
    const Cloud cloud = cloud_of_scene(s);
    Mode mode;
    mode.cam_from_centred = to_cloud(s.cam_from_target, cloud);
    mode.law = outlier_law(cloud);
    ASSERT_TRUE(fit_mixture(cloud, 10 * sigma_px / cloud.image_unit_px, {}, mode));
    // The standard deviation of a hundred pairs is known to a fourteenth.
    EXPECT_NEAR(std::sqrt(mode.variance) * cloud.image_unit_px, sigma_px, 0.3 * sigma_px);
    EXPECT_NEAR(mode.inliers, 100, 6);
    EXPECT_NEAR(mode.outlier_share, 0.5, 0.05);
  }
}

TEST(ConsensusMixture, FailsWithoutInliers) {
  Draw draw(7);
  const Cloud cloud = cloud_of_scene(scene({8, 0, false, 1}, draw));
  Mode mode;
  mode.cam_from_centred = {Eigen::Matrix3d::Identity(), {0, 0, -5}};
  mode.law = outlier_law(cloud);
  EXPECT_FALSE(fit_mixture(cloud, 1e-3, {}, mode));
}

TEST(ConsensusSearch, IsNotEndedByAgreementThatChanceExplains) {
  // Thirteen of 200 points that agree within 8 px, were that the noise, would be met with 99.9 %
  // after 40 000 triples. Ten that agree within 1 px, which is more than chance, take 100 000.
  for (const unsigned seed : {3, 5, 8}) {
    Draw draw(seed);
    Synthetic s = scene({200, 187, false, 8}, draw);
    s.problem.sigma_px = 0;
    EXPECT_GT(search(cloud_of_scene(s)).triples, 100'000) << seed;
  }
}

TEST(ConsensusModes, MirrorOfAPlaneKeepsItsImageAndOfASolidIsNone) {
  Draw draw(8);
  for (const bool is_planar : {false, true}) {
    const Pose pose = {draw.rotation_by(0.5), Eigen::Vector3d(0, 0, 1000)};
    const Synthetic s = exact_problem(centred_camera(640, 480, 100000),
                                      points_in_box(12, {1, 1, is_planar ? 0.0 : 1.0}, draw), pose);
    const Cloud cloud = cloud_of_scene(s);
    Mode mode;
    mode.cam_from_centred = to_cloud(s.cam_from_target, cloud);
    mode.weights.assign(cloud.size(), 1);
    const std::optional<Pose> mirror = mirrored(cloud, mode);
    ASSERT_EQ(mirror.has_value(), is_planar);
    if (!is_planar) continue;
    EXPECT_GT(geodesic_angle_rad(mirror->rotation, mode.cam_from_centred.rotation), 0.1);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      double r[2];
      ASSERT_TRUE(residual_at(cloud, *mirror, i, r));
      // Perspective's part in the image of a target that is a thousandth of its range across.
      EXPECT_LT(std::hypot(r[0], r[1]), 5e-3);
    }
  }
}

}  // namespace
}  // namespace sightline::consensus
