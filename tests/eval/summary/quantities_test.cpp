// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/summary/quantities.h"

#include <cmath>
#include <set>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "tests/eval/summary/handmade_trials.h"

namespace sightline {
namespace {

using namespace handmade;

TEST(Quantities, HaveNamesOfTheirOwn) {
  std::set<std::string> names, ids;
  for (const Quantity& one : quantities()) {
    EXPECT_TRUE(names.insert(one.name).second) << one.name;
    EXPECT_TRUE(ids.insert(one.id).second) << one.id;
    EXPECT_EQ(&quantity(one.name), &one);
  }
  EXPECT_THROW(quantity("cheerfulness"), std::out_of_range);
}

TEST(Quantities, AreMeasuredWhereTheyAreShown) {
  for (const Quantity& one : quantities()) {
    EXPECT_GT(one.cap, 0) << one.name;
    EXPECT_NE(one.summary, nullptr) << one.name;
    const auto is_shown = [](const QuantityView& view) {
      return view.heading != nullptr || view.is_charted;
    };
    EXPECT_TRUE(!is_shown(one.in_pose_studies) || one.of_estimate != nullptr) << one.name;
    EXPECT_TRUE(!is_shown(one.in_orientation_studies) || one.of_orientation != nullptr) << one.name;
  }
}

TEST(CellErrorStatistics, SummariseEveryErrorOfPosesAndAFailureAsTheCap) {
  CellErrorStatistics statistics;
  statistics.add(estimate("orpe", 2));
  statistics.add_failure();
  const CellErrors errors = statistics.summary(two_poses(), 0, "orpe");
  for (const Quantity& one : quantities()) {
    if (one.of_estimate == nullptr) continue;
    EXPECT_DOUBLE_EQ((errors.*one.summary).mean,
                     (estimate("orpe", 2).*one.of_estimate + one.cap) / 2)
        << one.name;
  }
  EXPECT_TRUE(std::isnan(errors.angle_error_deg.mean)) << "which poses do not have";
}

}  // namespace
}  // namespace sightline
