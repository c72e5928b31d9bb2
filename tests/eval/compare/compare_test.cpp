// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/compare/compare.h"

#include <sstream>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>

#include "eval/compare/compare_text.h"
#include "eval/compare/junit.h"
#include "scenes/files/input_error.h"
#include "tests/eval/program.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::ordered_json;

const std::string kStudy = "study cube-noise --quiet --set 'solvers=[\"orpe\", \"lspe\"]' ";
const std::string kBaselines = std::string(SIGHTLINE_SOURCE_DIR) + "/tests/baselines/";

class Compare : public testing::Test {
 protected:
  fs::path path(const std::string& name) const { return folder_.path() / name; }

  // Runs a small study into a folder of that name.
  fs::path make(const std::string& name, const std::string& arguments = "") const {
    const Outcome outcome =
        run(kStudy + "--trials 20 " + arguments + " --out " + path(name).string());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    return path(name);
  }

  // A summary.json of one cell with these means, intervals of +- 0.1 and failures.
  fs::path write_summary(const std::string& name, double mean, int trials = 1000,
                         int failures = 0) const {
    const Json error = {{"mean", mean}, {"mean_ci95", {mean - 0.1, mean + 0.1}}};
    const Json json = {{"study", "tiny"},
                       {"seed", 1},
                       {"cells",
                        {{{"condition", {{"noise_px", 2.0}}},
                          {"solver", "orpe"},
                          {"trials", trials},
                          {"failures", failures},
                          {"geodesic_deg", error},
                          {"t_error_percent", error}}}}};
    return folder_.write(name, json.dump());
  }

  TemporaryFolder folder_;
};

const CellDifference& cell_of(const Comparison& comparison, const std::string& condition,
                              const std::string& solver) {
  return *std::find_if(
      comparison.cells.begin(), comparison.cells.end(),
      [&](const CellDifference& c) { return c.condition == condition && c.solver == solver; });
}

TEST_F(Compare, ARunWithItselfIsUnchanged) {
  const fs::path base = make("base");
  const Comparison comparison = compare_runs(base, base, 0);
  EXPECT_EQ(comparison.cells.size(), 18u);
  EXPECT_EQ(comparison.count(Verdict::kUnchanged), 18);
  EXPECT_FALSE(comparison.has_regression());
  EXPECT_THAT(comparison.how, HasSubstr("paired: 180 trials"));
}

TEST_F(Compare, MoreNoiseIsWorseAndLessIsBetterOnTheSameTrials) {
  const fs::path base = make("base");
  const fs::path noisy = make("noisy", "--set noise.scale=2");
  const Comparison comparison = compare_runs(base, noisy, 0);
  EXPECT_THAT(comparison.how, HasSubstr("paired: 180 trials"));
  EXPECT_GE(comparison.count(Verdict::kWorse), 5) << "of 16 cells with noise, on 20 trials each";
  EXPECT_EQ(comparison.count(Verdict::kBetter), 0);
  EXPECT_EQ(cell_of(comparison, "noise_px 0.0", "orpe").verdict, Verdict::kUnchanged);
  const Difference& geodesic = cell_of(comparison, "noise_px 0.5", "orpe").differences[0];
  EXPECT_EQ(geodesic.quantity, "geodesic_deg.mean");
  EXPECT_GT(geodesic.ci95[0], 0);
  EXPECT_LT(geodesic.p, 0.05);
  EXPECT_TRUE(comparison.has_regression());

  const Comparison back = compare_runs(noisy, base, 0);
  EXPECT_EQ(back.count(Verdict::kBetter), comparison.count(Verdict::kWorse));
  EXPECT_FALSE(back.has_regression());
  // Twice the noise is some 100 % more error: all of it is allowed, or little of it.
  EXPECT_FALSE(compare_runs(base, noisy, 1).has_regression());
  EXPECT_TRUE(compare_runs(base, noisy, 0.1).has_regression());
}

TEST_F(Compare, TheProgramSaysSoInItsExitCodeAndFiles) {
  const std::string base = make("base").string();
  const std::string noisy = make("noisy", "--set noise.scale=2").string();
  const Outcome good = run("compare " + base + " " + base);
  EXPECT_EQ(good.exit_code, 0) << good.output;
  EXPECT_THAT(good.output, HasSubstr("0 worse, 0 better, 18 unchanged"));
  const std::string junit = path("junit.xml").string();
  const std::string markdown = path("compare.md").string();
  const Outcome bad =
      run("compare " + base + " " + noisy + " --junit " + junit + " --markdown " + markdown);
  EXPECT_EQ(bad.exit_code, 3) << bad.output;
  EXPECT_THAT(bad.output, HasSubstr("worse"));
  EXPECT_THAT(bad.output, HasSubstr("noise_px 0.5, orpe geodesic_deg.mean"));
  EXPECT_THAT(bad.output, HasSubstr("settings differ: noise.scale 1.0 to 2\n"));
  EXPECT_THAT(read_whole(junit), HasSubstr("<testsuite name=\"cube-noise\" tests=\"18\""));
  EXPECT_THAT(read_whole(junit), HasSubstr("<failure message=\"geodesic_deg.mean is worse"));
  EXPECT_THAT(read_whole(junit),
              HasSubstr("<property name=\"settings\" value=\"settings differ: noise.scale"));
  EXPECT_THAT(read_whole(markdown),
              HasSubstr("| noise_px 0.5 | orpe | geodesic_deg.mean | **worse** |"));
  EXPECT_EQ(run("compare " + base + " " + noisy + " --tolerance 1").exit_code, 0);
  // Python's own reader agrees that it is XML, where there is one.
  const Outcome parsed = run_shell(
      "command -v python3 >/dev/null || exit 0; python3 -c 'import sys, xml.dom.minidom; "
      "xml.dom.minidom.parse(sys.argv[1])' " +
      junit);
  EXPECT_EQ(parsed.exit_code, 0) << parsed.output;
}

TEST_F(Compare, OtherDrawsAreNotPaired) {
  const fs::path base = make("base");
  const Comparison other = compare_runs(base, make("other", "--seed 2"), 0);
  EXPECT_THAT(other.how, HasSubstr("not paired"));
  EXPECT_THAT(other.how, HasSubstr("the seeds are 1 and 2"));
  EXPECT_FALSE(other.has_regression());
  const Comparison near = compare_runs(base, make("near", "--set 'poses.range_m=[10, 20]'"), 0);
  EXPECT_THAT(near.how, HasSubstr("trial 0 is another draw in each"));
  EXPECT_GT(near.count(Verdict::kBetter), 0) << "a target five times as near";
}

TEST_F(Compare, ASolverThatIsGoneIsARegression) {
  const Comparison comparison =
      compare_runs(make("base"), make("new", "--set 'solvers=[\"lspe\"]'"), 0);
  EXPECT_EQ(comparison.count(Verdict::kMissing), 9);
  EXPECT_TRUE(comparison.has_regression());
  EXPECT_THAT(to_text(comparison), HasSubstr("missing"));
  EXPECT_THAT(to_junit(comparison), HasSubstr("the new run lacks this cell"));
}

// By hand: means 1 and 1.2 with half-widths of 0.1 differ by 0.2 +- 0.1414, so that t is
// 0.2 / 0.0722 = 2.77, two-sided p 0.0057 for many trials.
TEST_F(Compare, ComparesStoredIntervalsWhereThereAreNoTrials) {
  const fs::path base = write_summary("base.json", 1);
  const Comparison worse = compare_runs(base, write_summary("worse.json", 1.2), 0);
  const Difference& d = worse.cells[0].differences[0];
  EXPECT_NEAR(d.ci95[0], 0.2 - 0.1 * std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(d.ci95[1], 0.2 + 0.1 * std::sqrt(2.0), 1e-12);
  // Two of three numbers have this p; the third is 1. Holm: three times the least.
  EXPECT_NEAR(d.p, 3 * 0.0057, 0.0005);
  EXPECT_EQ(worse.cells[0].verdict, Verdict::kWorse);
  EXPECT_FALSE(compare_runs(base, write_summary("little.json", 1.05), 0).has_regression());
  EXPECT_FALSE(compare_runs(base, write_summary("allowed.json", 1.2), 0.2).has_regression());
  EXPECT_EQ(compare_runs(base, write_summary("better.json", 0.7), 0).count(Verdict::kBetter), 1);
}

TEST_F(Compare, CountsFailures) {
  const fs::path base = write_summary("base.json", 1, 100, 1);
  const Comparison worse = compare_runs(base, write_summary("worse.json", 1, 100, 20), 0);
  const Difference& failures = worse.cells[0].differences[2];
  EXPECT_EQ(failures.verdict, Verdict::kWorse);
  EXPECT_DOUBLE_EQ(failures.base, 0.01);
  EXPECT_DOUBLE_EQ(failures.now, 0.2);
  EXPECT_TRUE(worse.has_regression());
  EXPECT_FALSE(compare_runs(base, write_summary("same.json", 1, 100, 3), 0).has_regression());
  EXPECT_FALSE(compare_runs(base, path("worse.json"), 0.25).has_regression());
}

// Whatever a study, a condition or a solver is called, the XML reads back with the same names.
TEST(Junit, IsXmlWhateverTheNames) {
  Comparison comparison;
  comparison.study = "a<b> & \"c\" 'd'";
  comparison.cells.resize(3);
  CellDifference& worse = comparison.cells[0];
  worse.condition = "target.name bell\x07 \xEF\xBF\xBF]]>\nü";
  worse.solver = std::string("nul\0", 4);
  worse.verdict = Verdict::kMissing;
  CellDifference& better = comparison.cells[1];
  better.solver = "<!-- orpe -->";
  better.verdict = Verdict::kBetter;
  better.differences.emplace_back().quantity = "<&\"\x01";
  better.differences[0].verdict = Verdict::kBetter;

  pugi::xml_document document;
  const std::string text = to_junit(comparison);
  const pugi::xml_parse_result parsed = document.load_string(text.c_str(), pugi::parse_full);
  ASSERT_TRUE(parsed) << parsed.description() << "\n" << text;
  EXPECT_EQ(text.find_first_of("\x01\x07"), std::string::npos);
  EXPECT_THAT(text, Not(HasSubstr("&#0")));
  const pugi::xml_node suite = document.child("testsuites").child("testsuite");
  EXPECT_EQ(suite.attribute("name").value(), comparison.study);
  EXPECT_EQ(suite.attribute("tests").as_int(), 3);
  EXPECT_EQ(suite.attribute("failures").as_int(), 1);
  const pugi::xml_node first = suite.child("testcase");
  EXPECT_EQ(first.attribute("classname").value(),
            comparison.study + ".target.name bell\u2407 \uFFFD]]>\nü");
  EXPECT_STREQ(first.attribute("name").value(), "nul\u2400");
  EXPECT_STREQ(first.child("failure").attribute("message").value(), "the new run lacks this cell");
  const pugi::xml_node second = first.next_sibling("testcase");
  EXPECT_EQ(second.attribute("name").value(), better.solver);
  EXPECT_THAT(second.child("system-out").text().get(), HasSubstr("<&\"\u2401 is better"));
  EXPECT_FALSE(second.next_sibling("testcase").first_child()) << "nothing changed";
}

TEST_F(Compare, OfNumbersThatCannotBePassesNoGate) {
  const fs::path base = write_summary("base.json", 1);
  const auto complaint = [&](const std::string& what, const std::string& instead) {
    std::string text = read_whole(write_summary("new.json", 1));
    text.replace(text.find(what), what.size(), instead);
    const fs::path changed = folder_.write("new.json", text);
    return error_of([&] { compare_runs(base, changed, 0); });
  };
  EXPECT_EQ(complaint("\"failures\":0", "\"failures\":1"), "");
  EXPECT_THAT(complaint("\"failures\":0", "\"failures\":-1"),
              HasSubstr("new.json: not a summary.json of sightline's (failures is -1, must be"));
  EXPECT_THAT(complaint("\"failures\":0", "\"failures\":1001"), HasSubstr("from 0 to 1000"));
  EXPECT_THAT(complaint("\"mean\":1.0", "\"mean\":null"), HasSubstr("geodesic_deg.mean is null"));
  EXPECT_THAT(complaint("\"mean\":1.0", "\"mean\":-1"), HasSubstr("must be a number from 0"));
  EXPECT_THAT(complaint("\"trials\":1000", "\"trials\":1.5"), HasSubstr("must be a whole"));
}

// Whoever takes the bad trials out of a store must not pass for it.
TEST_F(Compare, OfAStoreThatWasEditedPassesNoGate) {
  const fs::path base = make("base");
  const fs::path now = path("now");
  const auto outputs_after = [&](const char* sql) {
    fs::remove_all(now);
    fs::copy(base, now, fs::copy_options::recursive);
    SQLite::Database((now / "results.sqlite").string(), SQLite::OPEN_READWRITE).exec(sql);
    const Outcome compared = run(fmt::format("compare {} {}", base.string(), now.string()));
    const Outcome reported = run(fmt::format("report {}", now.string()));
    EXPECT_EQ(compared.exit_code, reported.exit_code) << compared.output << reported.output;
    EXPECT_EQ(lines_of(compared.output) == 1, compared.exit_code == 1) << compared.output;
    return compared.exit_code == 1 ? compared.output : "";
  };
  EXPECT_EQ(outputs_after("UPDATE trials SET redraws = 0"), "");
  EXPECT_THAT(outputs_after("DELETE FROM estimates WHERE trial = 3"),
              HasSubstr("trial 3: has estimates of ''"));
  EXPECT_THAT(outputs_after("PRAGMA foreign_keys = OFF; DELETE FROM estimates WHERE trial = 3; "
                            "DELETE FROM observations WHERE trial = 3; "
                            "DELETE FROM trials WHERE trial = 3"),
              HasSubstr("results.sqlite: lacks trial 3; must hold every trial"));
  EXPECT_THAT(outputs_after("UPDATE estimates SET solver = 'best' WHERE solver = 'orpe'"),
              HasSubstr("has estimates of 'best, lspe'"));
  EXPECT_THAT(outputs_after("UPDATE estimates SET geodesic_deg = -1 WHERE trial = 5"),
              HasSubstr("trial 5: orpe: its geodesic_deg is -1"));
}

TEST_F(Compare, AnRmsOfASummaryAloneCannotBeCompared) {
  const Json error = {
      {"mean", 1.0}, {"mean_ci95", {0.9, 1.1}}, {"rms", 1.0}, {"rms_ci95", {nullptr, nullptr}}};
  Json json = Json::parse(read_whole(write_summary("base.json", 1)));
  json["cells"][0]["geodesic_deg"] = error;
  const std::string file = folder_.write("base.json", json.dump()).string();
  EXPECT_EQ(run("compare " + file + " " + file + " --measure geodesic_deg.mean").exit_code, 0);
  const Outcome rms = run("compare " + file + " " + file + " --measure geodesic_deg.rms");
  EXPECT_EQ(rms.exit_code, 1);
  EXPECT_THAT(rms.output, HasSubstr("does not tell it"));
}

TEST_F(Compare, BadInputIsOneLine) {
  const std::string base = write_summary("base.json", 1).string();
  const std::string other =
      folder_.write("other.json", R"({"study": "x", "seed": 1, "cells": []})");
  const std::string garbage = folder_.write("garbage.json", "{]");
  const std::string no_mean = folder_.write(
      "no_mean.json",
      R"({"study": "tiny", "seed": 1, "cells": [{"condition": {"noise_px": 2.0}, "solver": "orpe",
          "trials": 3}]})");
  for (const std::string& arguments :
       {base + " " + path("nothing").string(), base + " " + folder_.path().string(),
        base + " " + garbage, base + " " + other, other + " " + other, base + " " + no_mean,
        base + " " + base + " --junit /no/such/folder/x.xml"}) {
    const Outcome outcome = run("compare " + arguments);
    EXPECT_EQ(outcome.exit_code, 1) << arguments << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr("sightline: "));
  }
  EXPECT_EQ(run("compare " + base + " " + base + " --tolerance -1").exit_code, 2);
  EXPECT_EQ(run("compare " + base).exit_code, 2);
}

// The suite guards itself: studies as they were when their baselines were committed. Images differ
// between processors in single grey levels; the intervals allow for what that does. To accept a
// change, run the study with these arguments and copy its files over those in tests/baselines.
struct Guarded {
  const char* baseline;  // a summary.json alone, or with the trials beside it
  const char* arguments;
  const char* worse;  // further arguments: with what the pipeline is worse
};

class Guard : public Compare, public testing::WithParamInterface<Guarded> {};

TEST_P(Guard, NothingIsWorseThanItWas) {
  const auto [baseline, arguments, worse] = GetParam();
  const std::string out = path("now").string();
  ASSERT_EQ(run(std::string("study ") + arguments + " --quiet --out " + out).exit_code, 0);
  const Outcome outcome = run("compare " + kBaselines + baseline + " " + out);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
}

TEST_P(Guard, AWorsePipelineIsNoticed) {
  const auto [baseline, arguments, worse] = GetParam();
  const std::string out = path("worse").string();
  const std::string study = std::string("study ") + arguments + worse;
  ASSERT_EQ(run(study + " --quiet --out " + out).exit_code, 0);
  const Outcome outcome = run("compare " + kBaselines + baseline + " " + out);
  EXPECT_EQ(outcome.exit_code, 3) << outcome.output;
}

INSTANTIATE_TEST_SUITE_P(
    Baselines, Guard,
    testing::Values(Guarded{"cube-noise.json",
                            "cube-noise --trials 20 --set 'sweep.noise_px=[0.5, 2]' --set "
                            "'solvers=[\"orpe\", \"lspe\", \"oracle\"]'",
                            " --set noise.scale=4"},
                    Guarded{"boeing-random", "boeing-random --trials 30", " --set noise.scale=20"}),
    [](const auto& parameter) {
      return std::string(parameter.param.baseline).starts_with("cube") ? "CubeNoise"
                                                                       : "BoeingRandom";
    });

}  // namespace
}  // namespace sightline
