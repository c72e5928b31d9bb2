// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/ladder.h"

#include <cmath>

#include <gtest/gtest.h>

#include "pose/angles.h"
#include "scenes/random/random.h"
#include "tests/eval/summary/handmade_trials.h"

namespace sightline {
namespace {

constexpr double kDistanceM = 100;
const Vector6d kImageSds{{1e-5, 2e-5, 3e-5, 1e-3, 1e-3, 2e-2}};  // rad, m

// Two bounds, the outline's twice as wide, the oracle and ORPE.
struct LadderTrials {
  explicit LadderTrials(int count) {
    study = handmade::two_poses();
    for (const char* name : {"image_bound", "outline_bound"}) {
      TrialSolver bound;
      bound.name = name;
      bound.evaluation_only = true;
      images_of(study).solving.solvers.push_back(bound);
    }
    for (int i = 0; i < count; ++i) {
      TrialRecord& trial = trials.emplace_back();
      trial.trial = i;
      trial.condition = i % 2;
      trial.true_cam_from_target.translation = {0, 0, kDistanceM};
      trial.pose_trial().estimates = {pose("orpe", i, 3), pose("oracle", i, 1),
                                      bound("image_bound", 1), bound("outline_bound", 2)};
    }
  }

  static EstimateRecord bound(const char* name, double scale) {
    EstimateRecord estimate;
    estimate.solver = name;
    estimate.covariance = (scale * kImageSds).cwiseAbs2().asDiagonal();
    return estimate;
  }

  // Off by a draw of the image's bound, so many times as far.
  static EstimateRecord pose(const char* name, int trial, double scale) {
    RandomStream stream(5, name, static_cast<uint64_t>(trial));
    Vector6d error;
    for (int i = 0; i < 6; ++i) error[i] = scale * kImageSds[i] * stream.normal();
    EstimateRecord estimate;
    estimate.solver = name;
    estimate.geodesic_deg = error.head<3>().norm() / kDegree;
    estimate.t_error_percent = 100 * error.tail<3>().norm() / std::sqrt(3.0) / kDistanceM;
    return estimate;
  }

  EstimateRecord& orpe(size_t trial) { return trials[trial].pose_trial().estimates[0]; }

  LadderStep step(const std::string& from, const std::string& to) const {
    for (const LadderStep& step : summarise(study, trials).ladder) {
      if (step.from == from && step.to == to) return step;
    }
    ADD_FAILURE() << "no step from " << from << " to " << to;
    return {};
  }

  Study study;
  std::vector<TrialRecord> trials;
};

void expect_factor(const Measured& factor, double expected) {
  EXPECT_LT(factor.ci95[0], expected);
  EXPECT_GT(factor.ci95[1], expected);
  EXPECT_LT(factor.ci95[1] / factor.ci95[0], 1.4);  // it says something
}

TEST(Ladder, TellsOneBoundFromAnotherExactly) {
  const LadderStep step = LadderTrials(6).step("image", "outline alone");
  EXPECT_EQ(step.trials, 6);
  for (const Measured& factor : {step.geodesic, step.translation}) {
    EXPECT_NEAR(factor.value, 2, 1e-9);
    EXPECT_NEAR(factor.ci95[0], 2, 1e-9);
    EXPECT_NEAR(factor.ci95[1], 2, 1e-9);
  }
}

TEST(Ladder, StandsAtOneWhereABoundIsAttained) {
  const LadderTrials trials(200);
  expect_factor(trials.step("image", "orpe").geodesic, 3);
  expect_factor(trials.step("image", "orpe").translation, 3);
  expect_factor(trials.step("oracle, on the inliers", "orpe").geodesic, 3);
  LadderTrials attained(200);
  for (size_t i = 0; i < 200; ++i) attained.orpe(i) = LadderTrials::pose("orpe", int(i), 1);
  expect_factor(attained.step("image", "orpe").geodesic, 1);
}

TEST(Ladder, CountsAFailureAsTheCap) {
  LadderTrials trials(20);
  const double before = trials.step("image", "orpe").geodesic.value;
  const double error_deg = trials.orpe(4).geodesic_deg;
  trials.orpe(4).status = EstimateOutcome::kDegenerate;
  EXPECT_NEAR(trials.step("image", "orpe").geodesic.value,
              before * std::pow(20 / error_deg, 1.0 / 20), 1e-9 * before);
}

TEST(Ladder, LeavesOutATrialWithoutTheBound) {
  LadderTrials trials(6);
  trials.trials[2].pose_trial().estimates[2].covariance.reset();
  EXPECT_EQ(trials.step("image", "orpe").trials, 5);
  EXPECT_EQ(trials.step("outline alone", "points found").trials, 0);  // no features at all
}

TEST(Ladder, HasNoStepsWithoutTheImagesBound) {
  LadderTrials trials(4);
  images_of(trials.study).solving.solvers.resize(3);
  EXPECT_TRUE(summarise(trials.study, trials.trials).ladder.empty());
}

}  // namespace
}  // namespace sightline
