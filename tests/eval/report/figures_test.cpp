// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The figures of the report, each judged by the page of a small study.
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "eval/report/report.h"
#include "tests/eval/report/small_report.h"

namespace sightline {
namespace {

using namespace small_report;

TEST(SilhouetteFigure, SaysWhereTheOutlineShowsEachFeature) {
  SmallReport report;
  const std::string page = one_line(report.page());
  EXPECT_TRUE(has(page, "The outline beside each feature, at the true poses of 4 trials."));
  EXPECT_TRUE(has(page, "<td>4</td><td class=\"kind\">corner</td>"));
  report.trials[1].pose_trial().observations.clear();  // a pose that could not be imaged
  const std::string fewer = one_line(report.page());
  EXPECT_TRUE(has(fewer, "at the true poses of 3 of 4 trials."));
  EXPECT_TRUE(has(fewer, "<td>3</td><td class=\"kind\">corner</td>"));
}

TEST(SilhouetteFigure, OfManyTrialsTakesSome) {
  SmallReport report;
  EXPECT_FALSE(has(one_line(report.page()), "chosen at random"));
  for (int64_t i = 4; i < 400; ++i) report.trials.push_back(small_trial(i, 1));
  const std::string page = one_line(report.page());
  EXPECT_TRUE(has(page, "at the true poses of 300 of 400 trials."));
  EXPECT_TRUE(has(page, "<td>300</td><td class=\"kind\">corner</td>"));
  EXPECT_TRUE(has(page, "Views are those that show it, of poses chosen at random."));
}

TEST(SilhouetteFigure, IsAbsentWhereNoFeatureHasAnOutline) {
  SmallReport report;
  Target bare = *report.study.images()->target;
  bare.shapes.clear();
  images_of(report.study).target = std::make_shared<Target>(std::move(bare));
  EXPECT_FALSE(has(report.page(), "The outline beside each feature"));
}

TEST(AnswerFigure, StatesMeansIntervalsFailuresAndThePaper) {
  const std::string page = SmallReport().page();
  EXPECT_TRUE(has(page, "Is 1 &lt; 2 &amp; 2 &gt; 1?"));
  EXPECT_TRUE(has(page, "<b>1.75°</b>"));  // of 1.25 and 2.25
  EXPECT_TRUE(has(page, "The paper’s figures average 2.57° and 2.1&nbsp;%"));
  EXPECT_TRUE(has(page, "1 of 4 trials without a pose"));
}

TEST(AnswerFigure, ComparesSolversTrialByTrial) {
  SmallReport report;
  EXPECT_TRUE(has(report.page(), "the θ error of ORPE is 1.00° [1.00, 1.00] smaller"));
  for (size_t i = 0; i < report.trials.size(); ++i) {
    report.trials[i].pose_trial().estimates[1].theta_error_deg =
        report.trials[i].pose_trial().estimates[0].theta_error_deg + (i % 2 == 0 ? 0.5 : -0.5);
  }
  EXPECT_TRUE(has(report.page(), "do not tell the θ errors of ORPE and LSPE apart"));
}

TEST(AnswerFigure, LeavesConditionsWithoutTrialsOut) {
  const std::string page = report_of_pose_2().page();
  EXPECT_TRUE(has(page, "Over 2 trials in 1 of the 2 conditions"));
  EXPECT_TRUE(has(page, "<b>2.25°</b>"));
  EXPECT_TRUE(has(page, "The paper’s figures average 3.07° and 2.6&nbsp;%")) << "of pose 2 alone";
  EXPECT_TRUE(has(page, "is 0.12° and 0.046 % in the mean"));  // the bound
}

TEST(TableFigure, LeavesConditionsWithoutTrialsOutOfTheMeans) {
  const std::string page = report_of_pose_2().page();
  EXPECT_TRUE(has(page, "<b>–</b> <span class=\"interval\"></span>"));
  EXPECT_FALSE(has(page, "[–, –]"));
  EXPECT_TRUE(has(page, "<th scope=\"row\">bound</th><td>–</td>"));
  const std::string mean = page.substr(page.find("colspan=\"6\">mean<"));
  EXPECT_TRUE(has(mean, "<th scope=\"row\">bound</th><td>0.12</td><td></td> <td>0.046</td>"));
}

TEST(TableFigure, StandsBesideThePaper) {
  const std::string page = SmallReport().page();
  EXPECT_TRUE(has(page, "(−20, 30, 40)"));
  EXPECT_TRUE(has(page, "(−5, 5, 1300)"));
  EXPECT_TRUE(has(page, "<td class=\"beside\">2.07</td>"));
  EXPECT_TRUE(has(page, "[0.95, 1.65]"));
  EXPECT_TRUE(has(page, "colspan=\"6\">mean<"));
  EXPECT_TRUE(has(page, "3 of 12 estimates failed"));
}

TEST(TableFigure, ShowsMediansWhereThePaperPrintsNothing) {
  SmallReport report;
  for (Condition& condition : report.study.conditions) condition.paper.clear();
  images_of(report.study).setups.front().scene.poses = {};
  const std::string page = report.page();
  EXPECT_TRUE(has(page, "class=\"beside\">median</th>"));
  EXPECT_TRUE(has(page, "<td class=\"beside\">1.20</td>"));
  EXPECT_FALSE(has(page, "class=\"beside\">paper</th>"));
  EXPECT_FALSE(has(page, "The paper"));
  EXPECT_FALSE(has(page, "colspan=\"6\">mean<"));
  EXPECT_FALSE(has(page, "could not be imaged"));
}

TEST(TableFigure, NamesTheTrialsThatCouldNotBeImaged) {
  SmallReport report;
  report.trials[1].pose_trial().observations.clear();
  report.trials[3].pose_trial().observations.clear();
  const std::string page = report.page();
  EXPECT_TRUE(has(page, "Trials that could not be imaged: 2 of 4 trials"));
  EXPECT_TRUE(has(page, "<li>pose 2: 1, 3</li>"));
}

TEST(ExtractionFigure, SaysWhyAFeatureWasMissing) {
  const std::string page = SmallReport().page();
  EXPECT_TRUE(has(page, "too few edge pixels (4)"));
  EXPECT_TRUE(has(page, "4 (100.0 %)"));  // outliers of root
}

TEST(FramesFigure, ShowsTheEvidence) {
  const std::string page = SmallReport().page();
  EXPECT_EQ(count(page, "data:image/png;base64,"), 1u);  // once a frame, however many close-ups
  EXPECT_EQ(count(page, "<use href=\"#frame-1-image\"/>"), 4u);
  EXPECT_TRUE(has(page, "root: removed by ORPE"));
  EXPECT_TRUE(has(page, "<td class=\"text\">p2</td>"));
  EXPECT_TRUE(has(page, "fin: too few edge pixels"));
  EXPECT_TRUE(has(page, "id=\"frame-1-outline-0\""));
  EXPECT_FALSE(has(page, "id=\"frame-1-outline-1\""));  // no outline of LSPE was given
  for (const char* layer :
       {"windows", "edges", "lines", "found", "truth", "removed", "outline-2"}) {
    EXPECT_TRUE(has(page, std::string("id=\"show-") + layer + "\""));
  }
}

TEST(FramesFigure, MarksNoRemovalWhereNothingWasRemoved) {
  SmallReport report;
  report.frames[0].trial.record.pose_trial().estimates[0].removed.clear();
  EXPECT_FALSE(has(report.page(), "class=\"layer-removed"));
}

TEST(FramesFigure, ShowsAFailedSolverAndAFrameWithoutImage) {
  SmallReport report;
  report.frames[0].stored.pose_trial().estimates[0].status = EstimateOutcome::kTooFewPoints;
  EXPECT_TRUE(has(report.page(), "no pose: too few points"));
  report.frames[0].picture = {};
  EXPECT_FALSE(has(report.page(), "data:image/png"));
  EXPECT_TRUE(has(report.page(), "It could not be imaged."));
}

TEST(FramesFigure, StatesTheStoredNumbers) {
  SmallReport report;
  report.frames[0].stored.pose_trial().estimates[0].theta_error_deg = 7.89;
  report.frames[0].trial.record.pose_trial().estimates[0].theta_error_deg = 4.56;
  const std::string page = report.page();
  EXPECT_TRUE(has(page, "<td>7.89</td>"));
  EXPECT_FALSE(has(page, "<td>4.56</td>"));
}

TEST(ProvenanceFigure, RepeatsTheRunFromItsStudyFile) {
  SmallReport report;
  const auto page_of = [&report](const std::string& shard) {
    const ReportInput input{report.study,
                            report.summary,
                            report.trials,
                            report.frames,
                            {{"shard", shard}, {"command", "sightline study x --set 'a=<b>'"}}};
    return one_line(render_report(input));
  };
  EXPECT_TRUE(has(page_of("0/1"), "<code>sightline study study.toml --out again</code>"));
  EXPECT_TRUE(has(page_of("merged from 4"), "<code>sightline study study.toml --out again</code>"));
  EXPECT_TRUE(
      has(page_of("1/4"), "<code>sightline study study.toml --shard 1/4 --out again</code>"));
  EXPECT_TRUE(
      has(page_of("0/1"), "typed: <code>sightline study x --set &apos;a=&lt;b&gt;&apos;</code>"));
  EXPECT_TRUE(has(report.page(), "study.toml --out again"));  // without a manifest
  EXPECT_FALSE(has(report.page(), "What was typed"));
  EXPECT_FALSE(has(page_of("; rm -rf ~ #"), "shard ; rm")) << "a reader may copy it";
  EXPECT_FALSE(has(report.page(), "interrupt"));
}

TEST(FramesFigure, ListsEveryTrialWithItsErrorAndKind) {
  SmallReport report;
  report.trials[2].pose_trial().estimates[0].status = EstimateOutcome::kTooFewPoints;
  const std::string page = report.page();
  EXPECT_TRUE(has(page, R"("trial":[0,1,2,3],"condition":[0,1,0,1],"frame":[1,0,0,0])"));
  EXPECT_TRUE(has(page, R"("error":[[1.0,5.0,null,3.0],[2.0,6.0,3.0,4.0])"));
  EXPECT_TRUE(has(page, R"("kinds":["removed just the outliers","removed nothing, rightly",)"
                        R"("no pose: too few points"])"));
  EXPECT_TRUE(has(page, R"("shards":4)"));
}

// Two extractors on the same pictures, of which the second costs exactly one degree in every draw,
// while the draws differ by far more.
TEST(AnswerFigure, ComparesExtractorsOnTheSamePictures) {
  SmallReport report;
  report.study.conditions = {{"ours", {}, {}, {{"extractor", "ours"}}},
                             {"theirs", {}, {}, {{"extractor", "theirs"}}}};
  report.trials.clear();
  for (int draw = 0; draw < 8; ++draw) {
    const double error_deg = 2 + (draw * 5) % 8;
    report.trials.push_back(small_trial(2 * draw, error_deg));
    report.trials.push_back(small_trial(2 * draw + 1, error_deg + 1));
  }
  EXPECT_TRUE(has(report.page(),
                  "the θ error of ORPE with ours is 1.00° [1.00, 1.00] smaller than "
                  "that of ORPE with theirs in the mean"));
  report.study.conditions[1].values["noise.scale"] = 2;
  EXPECT_FALSE(has(report.page(), "ORPE with theirs")) << "these are other pictures";
}

}  // namespace
}  // namespace sightline
