// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/records/names.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "features/observation.h"
#include "pose/absolute_orientation.h"
#include "pose/solver.h"

namespace sightline {
namespace {

template <typename Enum>
void expect_each_name_once() {
  std::set<std::string_view> names;
  for (const std::string_view name : names_of(Enum{})) {
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_EQ(to_string(from_string<Enum>(name)), name);
  }
}

TEST(Names, ReadBackAsTheValueThatTheyName) {
  expect_each_name_once<ObservationOutcome>();
  expect_each_name_once<EstimateOutcome>();
  expect_each_name_once<ObservationLabel>();
  EXPECT_EQ(to_string(ObservationLabel::kPlanted), "planted");
  EXPECT_EQ(from_string<EstimateOutcome>("not imaged"), EstimateOutcome::kNotImaged);
}

TEST(Names, ThatAreUnknownAreNoValue) {
  for (const char* text : {"", "fine", "Ok", "ok "}) {
    EXPECT_THROW(from_string<EstimateOutcome>(text), UnknownName) << text;
  }
  try {
    from_string<ObservationLabel>("fine");
    FAIL();
  } catch (const UnknownName& error) {
    EXPECT_THAT(error.what(), ::testing::StartsWith("'fine' is none of inlier, wrong line,"));
  }
}

// A status that a solver, a method or an extractor can have, and records do not know, would end a
// study.
TEST(Names, OfWhatSolversMethodsAndExtractorsSayAreKnown) {
  for (int i = 0; i <= static_cast<int>(PoseStatus::kDiverged); ++i) {
    EXPECT_NO_THROW(from_string<EstimateOutcome>(to_string(static_cast<PoseStatus>(i))));
  }
  for (int i = 0; i <= static_cast<int>(OrientationStatus::kNotConverged); ++i) {
    EXPECT_NO_THROW(from_string<EstimateOutcome>(to_string(static_cast<OrientationStatus>(i))));
  }
  for (int i = 0; i <= static_cast<int>(ObservationStatus::kNoCorner); ++i) {
    EXPECT_NO_THROW(from_string<ObservationOutcome>(to_string(static_cast<ObservationStatus>(i))));
  }
}

}  // namespace
}  // namespace sightline
