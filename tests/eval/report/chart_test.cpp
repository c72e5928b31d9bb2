// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/report/chart.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "eval/report/figures.h"
#include "eval/report/gnuplot.h"
#include "eval/report/panels.h"
#include "eval/statistics/statistics.h"
#include "pose/attitude.h"
#include "pose/solver.h"
#include "tests/eval/studies.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Pointwise;

ChartAxis scaled(const std::vector<double>& values) {
  ChartAxis axis;
  choose_scale(axis, values);
  return axis;
}

TEST(ChartScale, IsLogarithmicWhereTheRangeAsksForIt) {
  EXPECT_TRUE(scaled({0.02, 0.5, 3}).is_log);
  EXPECT_DOUBLE_EQ(scaled({0.02, 0.5, 3}).low, 0.01);
  EXPECT_FALSE(scaled({0.2, 0.5, 3}).is_log);
  EXPECT_FALSE(scaled({-0.02, 0.5, 3}).is_log);
  EXPECT_FALSE(scaled({}).is_log);
}

TEST(ChartScale, DoesNotStretchDownToErrorsWithoutNoise) {
  EXPECT_FALSE(scaled({1e-13, 0, 0.5, 3}).is_log);
  EXPECT_DOUBLE_EQ(scaled({1e-13, 0.02, 3}).low, 0.01);
}

Study swept_study() {
  Study study;
  study.kind.emplace<NumericStudy>().solving.solvers = {built_in(*find_pose_solver("lspe")),
                                                        built_in(*find_pose_solver("orpe"))};
  for (const double outliers : {1.0, 2.0}) {
    for (const double noise_px : {3.0, 1.0, 2.0}) {
      Condition& condition = study.conditions.emplace_back();
      condition.label = std::to_string(noise_px) + " px, " + std::to_string(outliers);
      condition.values = {{"noise_px", noise_px}, {"outliers", outliers}};
    }
  }
  return study;
}

TEST(SweepPanels, PutTheQuantityWithMostValuesOnTheAxis) {
  const std::vector<SweepPanel> panels = sweep_panels(swept_study());
  ASSERT_EQ(panels.size(), 2u);
  EXPECT_EQ(panels[0].axis.label, "noise, px");
  EXPECT_EQ(panels[1].option, "outliers 2");
  EXPECT_THAT(panels[1].x, ElementsAre(1, 2, 3));
  EXPECT_THAT(panels[1].conditions, ElementsAre(4, 5, 3));
}

TEST(SweepPanels, GivenPosesAreWords) {
  Study study;
  study.conditions = {{"pose 1", {{"pose", 1}}}, {"pose 2", {{"pose", 2}}}};
  const std::vector<SweepPanel> panels = sweep_panels(study);
  ASSERT_EQ(panels.size(), 1u);
  EXPECT_THAT(panels[0].axis.names, ElementsAre("pose 1", "pose 2"));
  study.conditions.resize(1);
  EXPECT_TRUE(sweep_panels(study).empty());
}

// Errors of the first solver 1, 2, ... in tenths of a degree, of the second by half a degree more.
std::vector<TrialRecord> ramp(const Study& study, int count) {
  std::vector<TrialRecord> trials(count);
  for (int i = 0; i < count; ++i) {
    trials[i].trial = i;
    trials[i].condition = i % static_cast<int>(study.conditions.size());
    trials[i].true_cam_from_target.rotation =
        rotation_from_attitude({0.02 * (i % 20), 0.1 * (i / 20), 0});
    for (const double more : {0.0, 0.5}) {
      EstimateRecord& estimate = trials[i].pose_trial().estimates.emplace_back();
      estimate.theta_error_deg = 0.1 * (i + 1) + more;
      estimate.geodesic_deg = estimate.theta_error_deg;
      estimate.t_error_percent = 1;
    }
  }
  return trials;
}

struct Inputs {
  Study study = swept_study();
  Summary summary;
  std::vector<TrialRecord> trials = ramp(study, 60);
  ReportInput input() const { return {study, summary, trials, {}, {}}; }
};

const Chart& named(const std::vector<Chart>& charts, const std::string& id) {
  for (const Chart& chart : charts) {
    if (chart.id == id) return chart;
  }
  throw std::out_of_range("no chart " + id);
}

TEST(CumulativeCharts, CountEveryTrialAndEndAtTheCap) {
  Inputs inputs;
  inputs.trials[0].pose_trial().estimates[0].status = EstimateOutcome::kDiverged;
  inputs.trials[1].pose_trial().estimates[0].theta_error_deg = 25;
  const std::vector<Chart> charts = cumulative_charts(inputs.input());
  EXPECT_EQ(charts.size(), 2u * 7);  // two errors; all and six conditions
  const ChartSeries& all = named(charts, "cumulative-theta-1").series[0];
  EXPECT_EQ(all.x.back(), kAngleCapDeg);
  EXPECT_NEAR(all.y.back(), 100.0 * 58 / 60, 1e-9);  // the failed and the capped are in the whole
  EXPECT_EQ(all.x[0], 0.1 * 3);
  EXPECT_EQ(all.y[0], 0);
  EXPECT_NEAR(all.y[1], 100.0 / 60, 1e-9);
  const ChartSeries& other = named(charts, "cumulative-theta-1").series[1];
  EXPECT_EQ(other.y.back(), 100);
}

TEST(CumulativeCharts, AreThinnedToQuantiles) {
  Inputs inputs;
  inputs.trials = ramp(inputs.study, 1000);
  for (TrialRecord& trial : inputs.trials) trial.pose_trial().estimates[0].theta_error_deg /= 10;
  const ChartSeries series = cumulative_charts(inputs.input())[0].series[0];
  ASSERT_EQ(series.x.size(), 202u);
  EXPECT_NEAR(series.x[100], 5, 1e-9);  // half of the trials
  EXPECT_NEAR(series.y[100], 50, 1e-9);
}

TEST(BoxCharts, DrawQuantilesUpToTheCap) {
  Inputs inputs;
  inputs.study.conditions.resize(1);
  inputs.trials = ramp(inputs.study, 101);
  const std::vector<Chart> charts = boxes_charts(inputs.input());
  const ChartSeries& box = named(charts, "boxes-theta-1").series[0];
  EXPECT_NEAR(box.least[0], 0.6, 1e-12);
  EXPECT_NEAR(box.low[0], 2.6, 1e-12);
  EXPECT_NEAR(box.y[0], 5.1, 1e-12);
  EXPECT_NEAR(box.most[0], 9.6, 1e-12);
  for (TrialRecord& trial : inputs.trials)
    trial.pose_trial().estimates[0].status = EstimateOutcome::kDiverged;
  EXPECT_EQ(boxes_charts(inputs.input())[0].series[0].y[0], kAngleCapDeg);
}

TEST(PairedCharts, SubtractTrialByTrial) {
  Inputs inputs;
  const std::vector<Chart> charts = paired_charts(inputs.input());
  const Chart& chart = named(charts, "paired-theta-1");
  ASSERT_EQ(chart.series.size(), 1u);  // ORPE is what it is held against
  EXPECT_THAT(chart.title, HasSubstr("from ORPE"));
  EXPECT_EQ(chart.series[0].label, "LSPE");
  EXPECT_THAT(chart.series[0].y, Pointwise(DoubleNear(1e-9), {-0.5, -0.5, -0.5}));
  inputs.trials[0].pose_trial().estimates[0].status = EstimateOutcome::kDiverged;  // the cap
  const Chart failed = named(paired_charts(inputs.input()), "paired-theta-1");
  EXPECT_NEAR(failed.series[0].y[2], (20 - 0.6 - 9 * 0.5) / 10, 1e-9);
  numeric_of(inputs.study).solving.solvers.resize(1);
  EXPECT_TRUE(paired_charts(inputs.input()).empty());
}

TEST(AngleCharts, SortTrialsByPitchAndYaw) {
  Inputs inputs;
  const std::vector<Chart> charts = angles_charts(inputs.input());
  ASSERT_EQ(charts.size(), 2u);  // a solver each
  const ChartSeries& cells = charts[0].series[0];
  double trials = 0;
  for (const double count : cells.count) trials += count;
  EXPECT_EQ(trials, 60);
  EXPECT_EQ(cells.x.size(), 9u);
  EXPECT_LT(cells.value.front(), cells.value.back());  // later trials err more, and have more yaw
  numeric_of(inputs.study).setups[0].poses.theta_deg = {{0, 0, 0}};
  EXPECT_TRUE(angles_charts(inputs.input()).empty()) << "given poses are too few";
}

Chart small_chart() {
  Chart chart;
  chart.id = chart.group = "it's";
  chart.title = "</script> & 'quoted'";
  chart.x.label = "noise, px";
  chart.series = {{.label = "ORPE",
                   .style = 0,
                   .x = {1, 2},
                   .y = {0.123456789, std::numeric_limits<double>::quiet_NaN()},
                   .low = {0.1, 0.2},
                   .high = {0.3, 0.4}},
                  {.label = "bound", .x = {1}, .y = {0.01}}};
  return chart;
}

TEST(ChartJson, CannotEndItsElement) {
  const std::vector<Chart> charts = {small_chart()};
  const std::string text = charts_json(charts);
  EXPECT_THAT(text, Not(HasSubstr("<")));
  const auto json = nlohmann::json::parse(text)["charts"][0];
  EXPECT_EQ(json["title"], charts[0].title);
  EXPECT_EQ(json["series"][0]["y"][0], 0.12346);
  EXPECT_TRUE(json["series"][0]["y"][1].is_null());
  EXPECT_FALSE(json["series"][1].contains("low"));
}

TEST(Gnuplot, DataSayWhatTheirColumnsAre) {
  EXPECT_EQ(gnuplot_data(small_chart()),
            "# ORPE\n# x y low high least most value trials\n"
            "1 0.123456789 0.1 0.3 NaN NaN NaN NaN\n2 NaN 0.2 0.4 NaN NaN NaN NaN\n"
            "\n\n# bound\n# x y low high least most value trials\n"
            "1 0.01 NaN NaN NaN NaN NaN NaN\n");
}

TEST(Gnuplot, DrawsEveryKindTheSameTwice) {
  if (std::system("gnuplot --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no gnuplot";
  Inputs inputs;
  std::vector<Chart> charts = {small_chart()};
  charts[0].id = "lines";
  for (const auto& some : {cumulative_charts(inputs.input()), boxes_charts(inputs.input()),
                           paired_charts(inputs.input()), angles_charts(inputs.input())}) {
    charts.push_back(some.front());
  }
  charts.push_back(charts[0]);
  charts.back().id = "points";
  charts.back().kind = ChartKind::kPoints;
  charts.back().x.names = {"a", "b", "c'd"};
  const TemporaryFolder folder;
  ASSERT_EQ(write_figures(folder.path() / "figures", charts), "");
  for (const Chart& chart : charts) {
    const std::string svg = read_whole(folder.path() / "figures" / (chart.id + ".svg"));
    EXPECT_THAT(svg, HasSubstr("</svg>")) << chart.id;
    EXPECT_THAT(svg, HasSubstr("<path")) << chart.id;
  }
  ASSERT_EQ(write_figures(folder.path() / "again", charts), "");
  EXPECT_EQ(read_whole(folder.path() / "figures" / "lines.svg"),
            read_whole(folder.path() / "again" / "lines.svg"));
}

TEST(Gnuplot, WithoutItScriptsAndDataStand) {
  const std::string path = std::getenv("PATH");
  const TemporaryFolder folder;
  const std::vector<Chart> charts = {small_chart()};
  ::setenv("PATH", folder.path().c_str(), 1);
  const std::string note = write_figures(folder.path() / "figures", charts);
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(note, HasSubstr("gnuplot is not installed"));
  EXPECT_TRUE(fs::exists(folder.path() / "figures" / "it's.gp"));
  EXPECT_TRUE(fs::exists(folder.path() / "figures" / "it's.dat"));
  EXPECT_FALSE(fs::exists(folder.path() / "figures" / "it's.svg"));
}

}  // namespace
}  // namespace sightline
