// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/tables/result_table.h"

#include <algorithm>
#include <array>
#include <limits>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/eval/studies.h"
namespace sightline {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Study four_poses() {
  Study study;
  study.name = "boeing-table1";
  study.title = "ORPE Table 1: the pose of a rendered Boeing 707";
  study.reference = "ORPE paper, Table 1 and Fig. 4";
  study.conditions = {
      {"pose 1", {{"pose", 1}}, {{"orpe", {1.68, 0.5}}, {"lspe", {2.07, 1.7}}}},
      {"pose 2", {{"pose", 2}}, {{"orpe", {2.08, 2.4}}, {"lspe", {2.22, 2.8}}}},
  };
  ImageStudy& images = images_of(study);
  images.cells = {{.setup = 0, .pose = 0}, {.setup = 0, .pose = 1}};
  PoseLaw& poses = images.setups.emplace_back().scene.poses;
  poses.theta_deg = {{-20, 30, 40}, {-30, 50, 20}};
  poses.t_m = {{-5, 5, 1300}, {-8, 3, 1500}};
  images.target = load_target("boeing707");
  images.features = {0, 1, 2, 3, 4};
  for (const char* name : {"orpe", "lspe", "oracle"}) {
    images.solving.solvers.push_back(built_in(*find_pose_solver(name)));
  }
  return study;
}

ErrorSummary error(double mean, double low, double high) {
  ErrorSummary summary;
  summary.mean = mean;
  summary.mean_ci95 = {low, high};
  summary.median = mean - 0.25;
  return summary;
}

// The same in all cells, but for what the tests look for.
Summary summary_of(const Study& study) {
  Summary summary;
  for (int condition = 0; condition < static_cast<int>(study.conditions.size()); ++condition) {
    for (const TrialSolver& solver : study.solvers()) {
      CellSummary cell;
      cell.condition = condition;
      cell.solver = solver.name;
      cell.trials = 100;
      cell.theta_error_deg = error(1.5 + condition, 1.25 + condition, 1.75 + condition);
      cell.t_error_percent = error(0.5, 0.375, 0.625);
      cell.ratio_to_oracle = 1.25;
      cell.ratio_to_bound = 2;
      cell.false_removals = 0.125;
      cell.missed_outliers = 0.5;
      cell.exact_set_rate = 0.75;
      summary.cells.push_back(cell);
    }
    summary.observations.push_back(
        {condition, 100, /*repeated=*/0, 4.5, 0.75, 0.625, 0.375, 0.0625, 0.5});
    for (const char* feature : {"p1", "p2", "p3", "p4", "p5"}) {
      FeatureSummary of_feature;
      of_feature.condition = condition;
      of_feature.feature = feature;
      summary.features.push_back(of_feature);
    }
  }
  return summary;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// Characters, not bytes: those that do not continue another.
size_t width(const std::string& line) {
  return std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; });
}

void expect_tidy(const std::string& table) {
  for (const std::string& line : lines_of(table)) {
    EXPECT_LE(width(line), 100) << line;
    EXPECT_FALSE(line.ends_with(' ')) << line;
  }
}

TEST(Table, StandsBesideThePapersFigures) {
  const Study study = four_poses();
  const std::string table = to_table(study, summary_of(study));
  expect_tidy(table);
  EXPECT_EQ(table, R"(ORPE Table 1: the pose of a rendered Boeing 707
ORPE paper, Table 1 and Fig. 4
200 trials in 2 conditions, seed 1

Poses
            theta / °          T / m
────────────────────────────────────
pose 1  (-20, 30, 40)  (-5, 5, 1300)
pose 2  (-30, 50, 20)  (-8, 3, 1500)

theta_error / °, mean of the trials and its 95 % interval
        paper      orpe               lspe               oracle             bound
        orpe lspe  mean         95 %  mean         95 %  mean         95 %  mean
─────────────────────────────────────────────────────────────────────────────────
pose 1  1.68 2.07  1.50 [1.25, 1.75]  1.50 [1.25, 1.75]  1.50 [1.25, 1.75]  0.38
pose 2  2.08 2.22  2.50 [2.25, 2.75]  2.50 [2.25, 2.75]  2.50 [2.25, 2.75]  0.38
mean    1.88 2.15  2.00               2.00               2.00               0.38

T_error / % of the distance, mean of the trials and its 95 % interval
        paper      orpe               lspe               oracle             bound
        orpe lspe  mean         95 %  mean         95 %  mean         95 %  mean
─────────────────────────────────────────────────────────────────────────────────
pose 1   0.5  1.7  0.50 [0.38, 0.62]  0.50 [0.38, 0.62]  0.50 [0.38, 0.62]  0.06
pose 2   2.4  2.8  0.50 [0.38, 0.62]  0.50 [0.38, 0.62]  0.50 [0.38, 0.62]  0.06
mean     1.4  2.2  0.50               0.50               0.50               0.06

Geodesic error, and removals a trial, mean over the conditions
        rms/oracle  rms/bound  inliers removed  outliers kept  exactly right / %
────────────────────────────────────────────────────────────────────────────────
orpe          1.25       2.00             0.12           0.50               75.0
lspe          1.25       2.00             0.12           0.50               75.0
oracle        1.25       2.00             0.12           0.50               75.0

Features a trial
        found of 5  outliers  inlier rms / px
─────────────────────────────────────────────
pose 1        4.50      0.75             0.62
pose 2        4.50      0.75             0.62
mean          4.50      0.75             0.62
)");
}

// Without the paper's figures and given poses: one cell, as a study that draws its poses has.
Study drawn_poses() {
  Study study = four_poses();
  study.conditions = {{"all", {}, {}}};
  images_of(study).cells = {{}};
  images_of(study).setups.front().scene.poses = {};
  return study;
}

TEST(Table, ShowsMediansWhereThePaperHasNoFigures) {
  const Study study = drawn_poses();
  const std::string table = to_table(study, summary_of(study));
  expect_tidy(table);
  EXPECT_THAT(table, HasSubstr("100 trials in 1 condition, seed 1\n"));
  EXPECT_THAT(table, HasSubstr("mean         95 % median"));
  EXPECT_THAT(table, HasSubstr("all  1.50 [1.25, 1.75]   1.25  1.50"));
  EXPECT_THAT(table, Not(HasSubstr("paper  ")));
  EXPECT_THAT(table, Not(HasSubstr("Poses")));
  EXPECT_THAT(table, Not(HasSubstr("\nmean"))) << "the mean of one condition";
}

TEST(Table, SaysWhichSolversFailedAndHowOften) {
  const Study study = four_poses();
  Summary summary = summary_of(study);
  EXPECT_THAT(to_table(study, summary), Not(HasSubstr("failed")));
  summary.cells[0].failures = 2;
  summary.cells[3].failures = 1;
  const std::string table = to_table(study, summary);
  expect_tidy(table);
  EXPECT_THAT(table, HasSubstr("\nfailed: orpe 3 of 200, counted at the cap of 20° and 20 %\n"));
  EXPECT_THAT(table, Not(HasSubstr("failed: lspe")));
}

TEST(Table, PrintsADashForWhatIsNoNumber) {
  const Study study = drawn_poses();
  Summary summary = summary_of(study);
  for (CellSummary& cell : summary.cells) {
    cell.theta_error_deg.median = kInfinity;
    cell.ratio_to_oracle = kNaN;
  }
  summary.observations[0].bound_theta_deg = kNaN;
  const std::string table = to_table(study, summary);
  expect_tidy(table);
  EXPECT_THAT(table, HasSubstr("1.50 [1.25, 1.75]      -  1.50"));
  EXPECT_THAT(table, Not(HasSubstr("nan")));
  EXPECT_THAT(table, Not(HasSubstr("inf")));
}

TEST(Table, KeepsTwoDigitsOfSmallErrors) {
  const Study study = drawn_poses();
  Summary summary = summary_of(study);
  summary.cells[2].theta_error_deg = error(0.0123, 0.0118, 0.0129);
  EXPECT_THAT(to_table(study, summary), HasSubstr("0.012 [0.012, 0.013]"));
  EXPECT_THAT(to_table(study, summary), HasSubstr("1.500 [1.250, 1.750]"))
      << "decimals are those of the block";
}

TrialSolver solver_named(const std::string& name) {
  TrialSolver solver;
  solver.name = name;
  return solver;
}

TEST(Table, PutsSolversThatDoNotFitInFurtherBlocks) {
  constexpr std::array<const char*, 8> kNames{"a", "b", "c", "d", "e", "f", "g", "last_solver"};
  Study study = drawn_poses();
  images_of(study).solving.solvers.clear();
  for (const char* name : kNames) images_of(study).solving.solvers.push_back(solver_named(name));
  const std::string table = to_table(study, summary_of(study));
  expect_tidy(table);
  const std::vector<std::string> lines = lines_of(table);
  EXPECT_EQ(std::count_if(lines.begin(), lines.end(),
                          [](const std::string& line) { return line.starts_with("theta_error"); }),
            3);
  EXPECT_THAT(table, HasSubstr("last_solver"));
}

TEST(Table, OfASweepHoldsADozenSolversAndNineConditions) {
  Study study;
  NumericStudy& numeric = study.kind.emplace<NumericStudy>();
  study.title = "A sweep";
  study.claim = "All is well.";
  for (int i = 0; i < 12; ++i) {
    numeric.solving.solvers.push_back(solver_named("orpe_calibrated_" + std::to_string(i)));
  }
  for (int i = 0; i < 9; ++i) {
    study.conditions.push_back({std::to_string(i) + " px", {{"noise_px", i}}, {}});
    numeric.cells.push_back({});
  }
  const std::string table = to_table(study, summary_of(study));
  expect_tidy(table);
  const std::vector<std::string> lines = lines_of(table);
  EXPECT_LT(lines.size(), 170u);
  EXPECT_EQ(lines[1], "The paper: All is well.");
  EXPECT_EQ(std::count_if(lines.begin(), lines.end(),
                          [](const std::string& line) { return line.starts_with("8 px"); }),
            4 * 3)
      << "four quantities in three blocks each";
  EXPECT_EQ(std::count_if(lines.begin(), lines.end(),
                          [](const std::string& line) { return line.starts_with("mean"); }),
            0)
      << "a mean over noise levels says nothing";
}

TEST(Table, KeepsLongWordsWithinItsWidth) {
  Study study = four_poses();
  study.title =
      "A title that goes on and on, as titles do whose author had much to say about what "
      "the study asks, how it is done and who did it first, °°°°°°°°°°°°°°°°°°°°°°°°°°°°";
  study.reference = std::string(150, 'x');
  study.conditions[0].label = "a label that leaves no room for figures °°°°°°°°°°";
  expect_tidy(to_table(study, summary_of(study)));
}

// As of a shard that has no trial of pose 1.
TEST(Table, LeavesConditionsWithoutTrialsOutOfTheMeans) {
  const Study study = four_poses();
  Summary summary = summary_of(study);
  for (CellSummary& cell : summary.cells) {
    if (cell.condition != 0) continue;
    CellSummary empty;
    empty.solver = cell.solver;
    cell = empty;
  }
  summary.observations[0] = {};
  std::erase_if(summary.features, [](const FeatureSummary& f) { return f.condition == 0; });
  const std::string table = to_table(study, summary);
  expect_tidy(table);
  EXPECT_THAT(table, HasSubstr("100 of 200 trials in 1 of 2 conditions, seed 1\n"));
  EXPECT_THAT(table, HasSubstr(R"(
pose 1  1.68 2.07     -            -     -            -     -            -     -
pose 2  2.08 2.22  2.50 [2.25, 2.75]  2.50 [2.25, 2.75]  2.50 [2.25, 2.75]  0.38
mean    2.08 2.22  2.50               2.50               2.50               0.38
)"));
  EXPECT_THAT(table, HasSubstr("\norpe          1.25       2.00             0.12           0.50"));
  EXPECT_THAT(table, HasSubstr(R"(
        found of 5  outliers  inlier rms / px
─────────────────────────────────────────────
pose 1           -         -                -
pose 2        4.50      0.75             0.62
mean          4.50      0.75             0.62
)"));
}

TEST(Table, OfNoTrialsHasDashesForNumbers) {
  const Study study = four_poses();
  const std::string table = to_table(study, summarise(study, std::vector<TrialRecord>{}));
  expect_tidy(table);
  EXPECT_THAT(table, HasSubstr("0 trials in 0 of 2 conditions"));
  EXPECT_THAT(table, HasSubstr("found of 5"));
  EXPECT_THAT(table, Not(HasSubstr("0.0")));
}

}  // namespace
}  // namespace sightline
