// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How often consensus is right, how much worse it is than least squares on the true inliers, and
// whether its covariance is true, over some hundred draws.
#include <cmath>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/pose/consensus/scenes.h"
#include "tests/pose/solvers/solving.h"

namespace sightline {
namespace {

constexpr double kRight = 60;

struct Setting {
  DrawLaw law;
  bool is_sigma_known = true;
  int draws = 100;
};

std::ostream& operator<<(std::ostream& out, const Setting& s) {
  return out << s.law.outliers << " of " << s.law.points << (s.law.is_planar ? " planar" : " solid")
             << ", noise " << (s.is_sigma_known ? "known" : "unknown");
}

/// Sums over the draws of a setting.
struct Tally {
  int wrong = 0;
  int wrong_and_unflagged = 0;
  double squares = 0, oracle_squares = 0;  ///< of right answers
  double nees = 0;                         ///< of right answers

  void add(const Synthetic& s, const PoseEstimate& estimate, const PoseEstimate& oracle,
           double sigma_px) {
    const bool is_ok = estimate.status == PoseStatus::kOk;
    const double distance2 =
        is_ok ? squared_distance_from_truth(estimate.cam_from_target, s, sigma_px) : kInfinity;
    if (!(distance2 < kRight)) {
      ++wrong;
      const Diagnosis diagnosis = estimate.diagnosis.value_or(Diagnosis{});
      const bool is_flagged = !is_ok || diagnosis.is_ambiguous.value_or(false) ||
                              !diagnosis.is_significant.value_or(false);
      wrong_and_unflagged += !is_flagged;
      return;
    }
    squares += distance2;
    oracle_squares += squared_distance_from_truth(oracle.cam_from_target, s, sigma_px);
    if (!estimate.covariance) return;
    const Vector6d error = change_between(s.cam_from_target, estimate.cam_from_target);
    nees += error.dot(estimate.covariance->ldlt().solve(error));
  }
};

Tally tally(const Setting& setting, std::string_view solver) {
  Draw draw(100);
  Tally sum;
  for (int i = 0; i < setting.draws; ++i) {
    Synthetic s = scene(setting.law, draw);
    s.problem.sigma_px = setting.is_sigma_known ? setting.law.sigma_px : 0;
    sum.add(s, solve(solver, s.problem), solve("oracle", s.problem), setting.law.sigma_px);
  }
  return sum;
}

class ConsensusAccuracy : public testing::TestWithParam<Setting> {};

INSTANTIATE_TEST_SUITE_P(
    Settings, ConsensusAccuracy,
    testing::Values(Setting{{8, 2, false}, true}, Setting{{12, 6, false}, true},
                    Setting{{12, 6, false}, false}, Setting{{12, 6, true}, true},
                    Setting{{20, 10, true}, true}, Setting{{20, 10, true}, false},
                    Setting{{50, 35, false}, false}, Setting{{200, 180, false}, true, 40},
                    Setting{{200, 180, true}, false, 40}, Setting{{1000, 500, false}, false, 20},
                    Setting{{50, 25, false, 0.01}, false}, Setting{{50, 25, false, 5}, false}));

/// What is true of 99.9 % of draws fails twice in a hundred with a probability of 0.005. The mean
/// of chi-square of six degrees over n draws deviates by sqrt(12 / n); where the noise is estimated
/// from a few points the errors have the tails of Student's law, and the mean about twice that.
TEST_P(ConsensusAccuracy, IsRightAndKnowsHowRightItIs) {
  const Setting& setting = GetParam();
  const Tally sum = tally(setting, "consensus");
  EXPECT_LE(sum.wrong, 1);
  EXPECT_EQ(sum.wrong_and_unflagged, 0);
  const double right = setting.draws - sum.wrong;
  EXPECT_LT(std::sqrt(sum.squares / sum.oracle_squares), 1.1);
  const bool has_tails = !setting.is_sigma_known && setting.law.points <= 20;
  EXPECT_NEAR(sum.nees / right, 6, (has_tails ? 8 : 4) * std::sqrt(12 / right));
}

TEST_P(ConsensusAccuracy, LeastSquaresIsNot) {
  Setting setting = GetParam();
  setting.draws = 10;
  EXPECT_GT(tally(setting, "lspe").wrong, 5);
}

/// The mean is six where covariances are honest. Least squares on the true inliers of these targets
/// has 6.2: some are seen nearly from the edge, which bends the linear model. Of 2000 draws a mean
/// of chi-square deviates by 0.08, and several times that where few draws have long tails, so that
/// a unit is allowed: it is 6.8 and 6.6. Without the sets that lack one inlier the first is 7.4,
/// with the noise found as by the spread of the target's pixels the second 7.1.
TEST(ConsensusAccuracyOfPlanes, CovarianceOfFewInliersIsHonest) {
  for (const auto& [outliers, is_sigma_known] : {std::pair{4, true}, {2, false}}) {
    const Setting setting = {{8, outliers, true}, is_sigma_known, 2000};
    const Tally sum = tally(setting, "consensus");
    const double mean = sum.nees / (setting.draws - sum.wrong);
    EXPECT_NEAR(mean, 6, 1) << setting;
  }
}

TEST(ConsensusAccuracyOfFourInliers, WrongAnswersAreFlagged) {
  for (const bool is_planar : {false, true}) {
    for (const bool is_sigma_known : {false, true}) {
      const Setting setting = {{8, 4, is_planar}, is_sigma_known};
      const Tally sum = tally(setting, "consensus");
      EXPECT_LE(sum.wrong, 15) << setting;
      EXPECT_EQ(sum.wrong_and_unflagged, 0) << setting;
    }
  }
}

}  // namespace
}  // namespace sightline
