// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/bound_charts.h"

#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

Condition of_word(const std::string& key, const std::string& word) {
  Condition condition;
  condition.label = key + " " + word;
  condition.words[key] = word;
  return condition;
}

Condition of_number(const std::string& key, double number) {
  Condition condition;
  condition.label = key;
  condition.values[key] = number;
  return condition;
}

// Bounds that tell a row: 0.1, 0.2 ... of the attitude with the light unknown.
std::vector<Chart> charts_of(const std::vector<Condition>& conditions) {
  std::vector<ImageBoundRow> rows;
  for (size_t i = 0; i < conditions.size(); ++i) {
    const double value = 0.1 * static_cast<double>(i + 1);
    rows.push_back({conditions[i].label, 5, 5, {value / 2, value, 2 * value}, {1, 2, 3}});
  }
  return bound_charts(conditions, rows);
}

TEST(BoundCharts, LieOverTheMiddleOfARangeInItsOrder) {
  const auto charts = charts_of(
      {of_word("poses.range_m", "[4000.0,4000.0]"), of_word("poses.range_m", "[1000.0,2000.0]")});
  ASSERT_THAT(charts, SizeIs(2));
  EXPECT_EQ(charts[0].x.label, "poses.range_m");
  EXPECT_EQ(charts[0].kind, ChartKind::kLines);
  ASSERT_THAT(charts[0].series, SizeIs(3));
  EXPECT_THAT(charts[0].series[1].x, ElementsAre(1500, 4000));
  EXPECT_THAT(charts[0].series[1].y, ElementsAre(0.2, 0.1));
  EXPECT_THAT(charts[1].series[2].y, ElementsAre(3, 3));
}

TEST(BoundCharts, LieOverANumber) {
  const auto charts =
      charts_of({of_number("image.psf_sigma_px", 0.5), of_number("image.psf_sigma_px", 1)});
  EXPECT_THAT(charts[0].x.names, IsEmpty());
  EXPECT_THAT(charts[0].series[0].x, ElementsAre(0.5, 1));
}

TEST(BoundCharts, HaveAllPlacesOnTheirAxis) {
  const auto is_log = [](std::vector<double> places) {
    std::vector<Condition> conditions;
    for (const double place : places) {
      conditions.push_back(of_number("image.psf_sigma_px", place));
    }
    return charts_of(conditions)[0].x.is_log;
  };
  EXPECT_TRUE(is_log({0.01, 0.1, 1}));
  EXPECT_FALSE(is_log({0, 0.01, 1})) << "zero has no place on a logarithmic axis";
  EXPECT_FALSE(is_log({0.5, 1}));
}

// Two numbers that are no range from low to high are words.
TEST(BoundCharts, TakeNoPairForARange) {
  const auto charts = charts_of({of_word("camera.principal_point_px", "[256,200]"),
                                 of_word("camera.principal_point_px", "[200,256]")});
  EXPECT_THAT(charts[0].x.names, SizeIs(2));
}

// Words, numbers of given poses and two keys at once are no places on an axis of numbers.
TEST(BoundCharts, LieBesideEachOtherOtherwise) {
  Condition of_two = of_number("image.psf_sigma_px", 1);
  of_two.values["noise.scale"] = 2;
  for (const auto& conditions : std::vector<std::vector<Condition>>{
           {of_word("background.kind", "uniform"), of_word("background.kind", "clouds")},
           {of_number("pose", 1), of_number("pose", 2)},
           {of_number("image.psf_sigma_px", 2), of_two}}) {
    const auto charts = charts_of(conditions);
    EXPECT_EQ(charts[0].kind, ChartKind::kPoints);
    EXPECT_THAT(charts[0].x.names, ElementsAre(conditions[0].label, conditions[1].label));
    EXPECT_THAT(charts[0].series[1].x, ElementsAre(0, 1));
    EXPECT_THAT(charts[0].series[1].y, ElementsAre(0.1, 0.2));
  }
}

TEST(BoundCharts, AreNoneOfNothing) {
  EXPECT_THAT(charts_of({}), IsEmpty());
}

}  // namespace
}  // namespace sightline
