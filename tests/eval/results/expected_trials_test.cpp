// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the store of a whole run must hold, and that nothing else passes for one.
#include "eval/results/expected_trials.h"

#include <cmath>
#include <functional>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/results/store.h"
#include "tests/eval/results/stored_trials.h"
#include "tests/scenes/error_text.h"

namespace sightline {
namespace {

constexpr int kConditions = 4;  // of drawn_trial
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

// A trial with errors as a run has them.
TrialRecord sound_trial(int64_t number) {
  TrialRecord trial = drawn_trial(number);
  for (EstimateRecord& e : trial.pose_trial().estimates) {
    for (double* error : {&e.theta_error_deg, &e.t_error_percent, &e.geodesic_deg,
                          &e.reprojection_rms_px, &e.add_m, &e.mssd_m, &e.mspd_px}) {
      *error = std::abs(*error);
    }
  }
  return trial;
}

class ExpectedTrialsTest : public StoreTest {
 protected:
  // Eight trials of which `change` alters the sixth.
  std::string complaint(const std::function<void(TrialRecord&)>& change) const {
    std::vector<TrialRecord> trials;
    for (int i = 0; i < 8; ++i) trials.push_back(sound_trial(i));
    change(trials[5]);
    return complaint_of(trials, {{"trials", "8"}, {"shard", "0/1"}});
  }
  std::string complaint_of(const std::vector<TrialRecord>& trials,
                           const std::map<std::string, std::string>& meta) const {
    std::filesystem::remove(file());
    Store store = Store::create(file(), meta);
    store.add(trials);
    return error_of([&] {
      const ExpectedTrials expected = expected_trials(store, kConditions, {"orpe", "lspe"});
      const NextTrial next = checked_reader(store, expected);
      size_t count = 0;
      while (next()) ++count;
      EXPECT_EQ(count, trials.size());
    });
  }
};

TEST_F(ExpectedTrialsTest, AreReadWhereTheyAreWhole) {
  EXPECT_EQ(complaint([](TrialRecord&) {}), "");
  EXPECT_EQ(complaint_of({sound_trial(1), sound_trial(4), sound_trial(7)},
                         {{"trials", "9"}, {"shard", "1/3"}}),
            "");
}

TEST_F(ExpectedTrialsTest, MayFailAndMayNotKnowSomeErrors) {
  EXPECT_EQ(complaint([](TrialRecord& trial) {
              trial.true_cam_from_target.translation.setConstant(kNotANumber);
              for (EstimateRecord& e : trial.pose_trial().estimates) {
                e.status = EstimateOutcome::kDegenerate;
                e.geodesic_deg = kNotANumber;
              }
            }),
            "");
  EXPECT_EQ(complaint([](TrialRecord& trial) {
              trial.pose_trial().estimates[0].add_m = kNotANumber;
              trial.pose_trial().estimates[0].mspd_px = std::numeric_limits<double>::infinity();
            }),
            "");
}

TEST_F(ExpectedTrialsTest, SayWhatTheyAreNot) {
  const auto expect = [&](const char* reason, const std::function<void(TrialRecord&)>& change) {
    expect_complaint(complaint(change), file(), reason);
  };
  const auto first = [](TrialRecord& t) -> EstimateRecord& { return t.pose_trial().estimates[0]; };
  expect("trial 5: its condition is 3, must be 1", [](auto& t) { t.condition = 3; });
  expect("must be from 0 to 7", [](auto& t) { t.trial = -1; });
  expect("lacks trial 5; must hold every trial", [](auto& t) { t.trial = 9; });
  expect("trial 5: its redraws is -1", [](auto& t) { t.redraws = -1; });
  expect("trial 5: has estimates of 'lspe', must have those of 'orpe, lspe'",
         [](auto& t) { t.pose_trial().estimates.erase(t.pose_trial().estimates.begin()); });
  expect("has estimates of 'magic, lspe'", [&](auto& t) { first(t).solver = "magic"; });
  expect("orpe: its geodesic_deg is nan", [&](auto& t) { first(t).geodesic_deg = kNotANumber; });
  expect("orpe: its theta_error_deg is -1", [&](auto& t) { first(t).theta_error_deg = -1; });
  expect("orpe: its add_m is -1", [&](auto& t) { first(t).add_m = -1; });
  expect("orpe: its missed_outliers is -1", [&](auto& t) { first(t).missed_outliers = -1; });
  expect("orpe: its pose has what is no finite number",
         [&](auto& t) { first(t).cam_from_target.translation.x() = kNotANumber; });
  expect("fin_tip: has a line without a place, a direction or noise",
         [](auto& t) { t.pose_trial().lines[0].offset_variance_px2 = 0; });
  expect("its true pose is not finite",
         [](auto& t) { t.true_cam_from_target.rotation(0, 0) = kNotANumber; });
}

TEST_F(ExpectedTrialsTest, AreAllThereAndOfTheirShard) {
  const std::vector<TrialRecord> trials{sound_trial(1), sound_trial(4)};
  const auto expect = [&](const char* reason, const char* count, const char* shard) {
    expect_complaint(complaint_of(trials, {{"trials", count}, {"shard", shard}}), file(), reason);
  };
  expect("lacks trial 7; must hold every trial of shard 1 of 3", "9", "1/3");
  expect("has trial 1, which is not of shard 0 of 2", "9", "0/2");
  expect("is shard 'x', must be I/N", "9", "x");
  expect("says that it is of 'all' trials", "all", "0/1");
}

}  // namespace
}  // namespace sightline
