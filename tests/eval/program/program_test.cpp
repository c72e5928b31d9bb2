// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The program as a user runs it: real processes, real files.
#include "tests/eval/program.h"

#include <regex>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "eval/work/processors.h"
#include "pose/solver.h"
#include "scenes/picture/picture_file.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Program : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string results(const std::string& run_name, const std::string& file) const {
    return read_whole(folder_.path() / run_name / file);
  }
  TemporaryFolder folder_;
};

TEST_F(Program, DoctorSaysWhoDraws) {
  const Outcome outcome = run("doctor");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  for (const char* text : {"own rasteriser", "--gl osmesa", "--gl egl", "--shard auto", "assets"}) {
    EXPECT_THAT(outcome.output, HasSubstr(text));
  }
  EXPECT_THAT(outcome.output, testing::Not(HasSubstr("promised")));  // only when asked
}

TEST_F(Program, AnOpenGlThatNobodyKnowsIsAUsageError) {
  const Outcome outcome = run("study boeing-table1 --trials 1 --gl vulkan --out " + path("run"));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.output, HasSubstr("osmesa"));
  EXPECT_FALSE(fs::exists(path("run")));
}

TEST_F(Program, RunsTable1FromMeshToReport) {
  const Outcome outcome = run("study boeing-table1 --trials 2 --out " + path("run"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  for (const char* file : {"study.toml", "manifest.json", "results.sqlite", "results.csv",
                           "summary.json", "report.html", "figures/boxes-theta-1.gp",
                           "figures/boxes-theta-1.dat", "figures/boxes-theta-1.svg"}) {
    EXPECT_TRUE(fs::exists(folder_.path() / "run" / file)) << file;
  }
  EXPECT_THAT(outcome.output, HasSubstr("report.html"));
  EXPECT_THAT(outcome.output, HasSubstr("2.07"));  // the paper's mean stands beside ours
  EXPECT_EQ(lines_of(results("run", "results.csv")), 1 + 8 * 3u);  // header, 8 trials x 3 solvers
  const auto summary = nlohmann::json::parse(results("run", "summary.json"));
  EXPECT_EQ(summary["study"], "boeing-table1");
  EXPECT_EQ(summary["cells"].size(), 4 * 3u);
  EXPECT_THAT(results("run", "report.html"), HasSubstr("</html>"));
}

TEST_F(Program, JobsShardsAndRepetitionsGiveTheSameResults) {
  const std::string study = "study boeing-random --trials 5 --quiet ";
  ASSERT_EQ(run(study + "--jobs 1 --out " + path("one")).exit_code, 0);
  ASSERT_EQ(run(study + "--jobs 2 --out " + path("two")).exit_code, 0);
  std::string merge = "merge";
  for (int i = 0; i < 3; ++i) {
    const std::string shard = path("shard" + std::to_string(i));
    ASSERT_EQ(run(study + "--shard " + std::to_string(i) + "/3 --out " + shard).exit_code, 0);
    merge += " " + shard;
  }
  ASSERT_EQ(run(merge + " --out " + path("merged")).exit_code, 0);
  for (const char* file : {"results.csv", "summary.json"}) {
    EXPECT_EQ(results("one", file), results("two", file)) << file;
    EXPECT_EQ(results("one", file), results("merged", file)) << file;
  }
  ASSERT_EQ(run(study + "--seed 2 --out " + path("other")).exit_code, 0);
  EXPECT_NE(results("one", "results.csv"), results("other", "results.csv"));

  // Four shards of four poses: each holds one pose alone, and together they are the whole.
  const std::string table = "study boeing-table1 --trials 2 --quiet ";
  ASSERT_EQ(run(table + "--out " + path("table")).exit_code, 0);
  std::string merge_table = "merge";
  for (int i = 3; i >= 0; --i) {
    const std::string shard = path("table" + std::to_string(i));
    ASSERT_EQ(run(table + "--shard " + std::to_string(i) + "/4 --out " + shard).exit_code, 0);
    merge_table += " " + shard;
  }
  ASSERT_EQ(run(merge_table + " --out " + path("table-merged")).exit_code, 0);
  EXPECT_EQ(results("table", "results.csv"), results("table-merged", "results.csv"));
  EXPECT_EQ(results("table", "summary.json"), results("table-merged", "summary.json"));

  // The other half of the promise: shards that do not belong together are refused.
  const Outcome missing =
      run("merge " + path("shard0") + " " + path("shard1") + " --out " + path("x"));
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.output, HasSubstr("shard 2 of 3 is missing"));
  const Outcome twice =
      run("merge " + path("shard0") + " " + path("shard0") + " --out " + path("x"));
  EXPECT_THAT(twice.output, HasSubstr("both shard 0 of 3"));
  const Outcome mixed = run("merge " + path("one") + " " + path("other") + " --out " + path("x"));
  EXPECT_THAT(mixed.output, HasSubstr("differs"));
  EXPECT_FALSE(fs::exists(path("x")));
}

TEST_F(Program, NumericStudiesRepeatWhateverTheJobsAndShards) {
  for (const std::string name : {"cube-noise", "orientation-points"}) {
    const std::string study = "study " + name + " --trials 4 --quiet --out ";
    ASSERT_EQ(run(study + path(name + "-one") + " --jobs 1").exit_code, 0);
    ASSERT_EQ(run(study + path(name + "-two") + " --jobs 3").exit_code, 0);
    ASSERT_EQ(run(study + path(name + "-s1") + " --shard 1/2").exit_code, 0);
    ASSERT_EQ(run(study + path(name + "-s0") + " --shard 0/2 --jobs 2").exit_code, 0);
    ASSERT_EQ(run("merge " + path(name + "-s1") + " " + path(name + "-s0") + " --out " +
                  path(name + "-merged"))
                  .exit_code,
              0);
    for (const char* file : {"results.csv", "summary.json"}) {
      EXPECT_EQ(results(name + "-one", file), results(name + "-two", file)) << name << file;
      EXPECT_EQ(results(name + "-one", file), results(name + "-merged", file)) << name << file;
    }
    EXPECT_FALSE(fs::exists(folder_.path() / (name + "-one") / "timings.csv"));
    ASSERT_EQ(run(study + path(name + "-other") + " --seed 2").exit_code, 0);
    EXPECT_NE(results(name + "-one", "results.csv"), results(name + "-other", "results.csv"));
  }
}

TEST_F(Program, TakesAllProcessorsButWhereTheWorkIsSpreadOrTimed) {
  const auto jobs_of = [&](const std::string& name, const std::string& study) {
    EXPECT_EQ(run("study " + study + " --trials 4 --quiet --out " + path(name)).exit_code, 0);
    return nlohmann::json::parse(results(name, "manifest.json")).at("jobs").get<int>();
  };
  EXPECT_EQ(jobs_of("plain", "cube-noise"), usable_processors());
  EXPECT_EQ(jobs_of("given", "cube-noise --jobs 3"), 3);
  EXPECT_EQ(jobs_of("shard", "cube-noise --shard 0/2"), 1);
  EXPECT_EQ(jobs_of("timed", "orientation-speed --set timed_repeats=1"), 1);
}

TEST_F(Program, PlansWhateverTheJobsAndLeavesNothing) {
  const std::string plan =
      "study cube-noise --trials 20 --plan 0.05 --quiet "
      "--set 'solvers=[\"lspe\"]' --set outliers.count=0 ";
  const std::string in_here = "cd " + folder_.path().string() + " && TMPDIR=. ";
  const Outcome one = run_shell(in_here + SIGHTLINE_PROGRAM + " " + plan + "--jobs 1");
  const Outcome two = run_shell(in_here + SIGHTLINE_PROGRAM + " " + plan + "--jobs 2");
  ASSERT_EQ(one.exit_code, 0) << one.output;
  EXPECT_EQ(one.output, two.output);
  EXPECT_TRUE(std::regex_search(one.output, std::regex("\n0 px +-\n"))) << one.output;
  EXPECT_TRUE(std::regex_search(one.output, std::regex("\n4 px +[0-9]+\n"))) << one.output;
  EXPECT_THAT(one.output, HasSubstr("The most: --trials "));
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(Program, CubeStudiesHaveTheConditionsOfTheContract) {
  const Outcome outcome = run("study cube-outliers --trials 10 --out " + path("run"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("below 1.3 degrees"));  // what the paper claims
  EXPECT_THAT(outcome.output, HasSubstr("3 outliers"));
  const auto summary = nlohmann::json::parse(results("run", "summary.json"));
  const size_t solvers = pose_solvers().size();
  ASSERT_EQ(summary["cells"].size(), 4 * solvers) << "every solver there is";
  for (int outliers = 0; outliers < 4; ++outliers) {
    const auto& cell = summary["cells"][solvers * static_cast<size_t>(outliers)];
    EXPECT_EQ(cell["condition"].dump(), "{\"outliers\":" + std::to_string(outliers) + "}");
    EXPECT_EQ(cell["solver"], "orpe");
    EXPECT_EQ(cell["trials"], 10);
    EXPECT_EQ(summary["observations"][static_cast<size_t>(outliers)]["outliers_per_trial"],
              outliers);
  }
  EXPECT_EQ(lines_of(results("run", "results.csv")), 1 + 40 * solvers);
}

TEST_F(Program, OrientationSpeedKeepsTimesOutOfTheResults) {
  const std::string study =
      "study orientation-speed --trials 2 --set timed_repeats=3 --set \"methods=['fast']\" --out ";
  const Outcome outcome = run(study + path("run"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("Time of a solve / ns"));
  ASSERT_EQ(run(study + path("again")).exit_code, 0);
  for (const char* file : {"results.csv", "summary.json"}) {
    EXPECT_EQ(results("run", file), results("again", file)) << file;
    EXPECT_THAT(results("run", file), testing::Not(HasSubstr("time"))) << file;
  }
  const std::string timings = results("run", "timings.csv");
  EXPECT_EQ(lines_of(timings), lines_of(results("run", "results.csv")));
  const auto summary = nlohmann::json::parse(results("run", "summary.json"));
  const auto& cell = summary["cells"][0];
  EXPECT_EQ(cell["condition"].dump(), R"({"points":3})");
  EXPECT_EQ(cell["solver"], "fast");
  EXPECT_GT(cell["angle_error_deg"]["mean"].get<double>(), 0);
  fs::remove(folder_.path() / "run" / "timings.csv");
  ASSERT_EQ(run("report " + path("run")).exit_code, 0);
  EXPECT_EQ(results("run", "timings.csv"), timings);
}

TEST_F(Program, ReportIsWrittenAnewFromTheTrials) {
  ASSERT_EQ(run("study boeing-random --trials 2 --quiet --out " + path("run")).exit_code, 0);
  const std::string csv = results("run", "results.csv");
  fs::remove(folder_.path() / "run" / "results.csv");
  fs::remove(folder_.path() / "run" / "report.html");
  const Outcome outcome = run("report " + path("run"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(results("run", "results.csv"), csv);
  EXPECT_TRUE(fs::exists(folder_.path() / "run" / "report.html"));
  // Of a run that somebody sent, whose manifest is made to crash what walks through it.
  constexpr size_t kDeep = 1'000'000;
  folder_.write("run/manifest.json",
                "{\"command\": " + std::string(kDeep, '[') + std::string(kDeep, ']') + "}");
  const Outcome deep = run("report " + path("run"));
  EXPECT_EQ(deep.exit_code, 0) << deep.output;
}

TEST_F(Program, TrialsThatCannotBeImagedAreCountedAndSaid) {
  const Outcome outcome =
      run("study boeing-random --trials 2 --set 'poses.lateral_m=[400, 500]' --set "
          "poses.max_redraws=1 --out " +
          path("run"));
  EXPECT_EQ(outcome.exit_code, 4) << outcome.output;
  EXPECT_THAT(results("run", "results.csv"), HasSubstr("not imaged"));
}

TEST_F(Program, BadInputIsOneLineAndLeavesNothing) {
  const std::string out = " --out " + path("run");
  const auto bad_mesh = folder_.write("bad.glb", "nonsense");
  const auto bad_toml = folder_.write("bad.toml", "a = = 1\n");
  for (const std::string& arguments :
       {"study boeing-tabel1" + out, "study " + bad_toml.string() + out,
        "study boeing-table1 --set trails=2" + out, "study boeing-table1 --set target=teapot" + out,
        "study boeing-table1 --set target=" + bad_mesh.string() + out,
        "study boeing-table1 --set target=/no/such.glb" + out,
        "study boeing-table1 --trials 1 --out " + bad_toml.string(),
        std::string("study boeing-table1 --trials 1 --out /proc/nowhere"),
        "study boeing-table1 --shard 3/2" + out, "study cube-noise --set noise.pixel_px=1" + out,
        "study cube-outliers --set outliers.law=swapped" + out,
        "study orientation-points --set 'methods=[\"fats\"]'" + out, "target " + bad_mesh.string(),
        std::string("target boing707"), std::string("list target"),
        "merge " + path("nothing") + out, "report " + path("nothing")}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 1) << arguments << "\n" << outcome.output;
    EXPECT_EQ(lines_of(outcome.output), 1u) << arguments << "\n" << outcome.output;
  }
  EXPECT_FALSE(fs::exists(path("run")));
  // Nothing but the two files written above: no staging folder is left.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 2);
}

TEST_F(Program, LinksInACircleAreOneLineOfOurs) {
  fs::create_directories(path("set/test"));
  fs::create_directory_symlink("000001", path("set/test/000001"));
  const Outcome outcome =
      run("score " + path("r.csv") + " --dataset " + path("set") + " --out " + path("scores"));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(lines_of(outcome.output), 1u) << outcome.output;
  EXPECT_THAT(outcome.output, testing::AllOf(HasSubstr("test/000001"), HasSubstr("symbolic links"),
                                             testing::Not(HasSubstr("filesystem error"))));
}

TEST_F(Program, AnOutputFolderInUseIsRefusedAndKept) {
  folder_.write("kept.txt", "precious");
  const Outcome outcome = run("study boeing-table1 --trials 1 --out " + folder_.path().string());
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.output, HasSubstr("not empty"));
  EXPECT_EQ(read_whole(folder_.path() / "kept.txt"), "precious");
}

TEST_F(Program, FoldersThatHadToBeMadeDoNotOutliveAFailure) {
  const auto broken = folder_.write("broken.toml", "title = 3\n");
  EXPECT_EQ(run("study " + broken.string() + " --out " + path("a/b/c")).exit_code, 1);
  EXPECT_EQ(run("merge " + path("nothing") + " --out " + path("a/b/c")).exit_code, 1);
  EXPECT_FALSE(fs::exists(path("a")));
}

TEST_F(Program, WhatARunLeftThatFinishedNothingIsSweptByTheNext) {
  const fs::path stale = folder_.path() / ".run.partial";
  fs::create_directories(stale);
  folder_.write(".run.partial/.lock", "");  // by which a run knows it for one of ours
  folder_.write(".run.partial/results.sqlite.partial", "half a store");
  ASSERT_EQ(run("study boeing-table1 --trials 1 --quiet --out " + path("run")).exit_code, 0);
  EXPECT_FALSE(fs::exists(stale));
  EXPECT_FALSE(fs::exists(folder_.path() / "run" / "results.sqlite.partial"));
}

TEST_F(Program, TheManifestWritesNumbersAsNumbers) {
  ASSERT_EQ(
      run("study cube-noise --trials 1 --quiet --seed 3 --jobs 2 --out " + path("run")).exit_code,
      0);
  const auto manifest = nlohmann::json::parse(results("run", "manifest.json"));
  EXPECT_EQ(manifest["seed"], 3);
  EXPECT_EQ(manifest["jobs"], 2);
  EXPECT_EQ(manifest["trials"], 9);
  EXPECT_GT(manifest["wall_s"].get<double>(), 0);
  EXPECT_TRUE(manifest["version"].is_string());
}

TEST_F(Program, AnOptionThatDoesNothingIsRefused) {
  EXPECT_EQ(run("target cube --forward=+x").exit_code, 1);
  EXPECT_EQ(run("target cube --theta=nan,0,0").exit_code, 1);
}

TEST_F(Program, UsageErrorsExitWithTwo) {
  EXPECT_EQ(run("").exit_code, 2);
  EXPECT_EQ(run("fly").exit_code, 2);
  EXPECT_EQ(run("study").exit_code, 2);
  EXPECT_EQ(run("study boeing-table1 --trials many").exit_code, 2);
  EXPECT_EQ(run("--help").exit_code, 0);
  EXPECT_EQ(run("--version").exit_code, 0);
}

TEST_F(Program, ListsWhatTheCataloguesHold) {
  const Outcome all = run("list");
  EXPECT_EQ(all.exit_code, 0);
  for (const char* name :
       {"boeing707", "cube", "hough_intersection", "shi_tomasi_nearest", "orpe", "lspe", "oracle",
        "walker_dual_quaternion", "boeing-table1", "boeing-random", "cube-noise", "cube-outliers",
        "orientation-points", "orientation-noise", "orientation-outliers", "orientation-speed",
        "ransac_umeyama"}) {
    EXPECT_THAT(all.output, HasSubstr(name));
  }
  EXPECT_THAT(run("list solvers").output, testing::Not(HasSubstr("cube")));
}

TEST_F(Program, DescribesAndDrawsATarget) {
  const Outcome outcome = run("target boeing707 --picture " + path("b.png"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("46.610"));
  EXPECT_THAT(outcome.output, HasSubstr("closed"));
  EXPECT_EQ(read_picture_file(path("b.png")).pixels.channels(), 1);
  run("target boeing707_livery --picture " + path("painted.png"));
  EXPECT_EQ(read_picture_file(path("painted.png")).pixels.channels(), 3);
  EXPECT_EQ(run("target cube --picture " + path("no/b.png")).exit_code, 1);
}

TEST_F(Program, ProposesATargetThatAStudyUses) {
  // A box of 40 m x 20 m x 10 m in millimetres, its second axis up.
  const auto mesh = folder_.write(
      "box.off",
      "OFF\n8 6 12\n0 0 0\n40000 0 0\n40000 10000 0\n0 10000 0\n0 0 20000\n40000 0 20000\n"
      "40000 10000 20000\n0 10000 20000\n4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 2 3 7 6\n"
      "4 1 2 6 5\n4 0 4 7 3\n");
  const std::string propose =
      "target " + mesh.string() + " --unit mm --up y --propose " + path("box");
  const Outcome outcome = run(propose);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("40.000 x 20.000 x 10.000 m"));
  EXPECT_GT(fs::file_size(path("box/features.png")), 10000u);
  const std::string target = read_whole(path("box/target.toml"));
  EXPECT_THAT(target, HasSubstr("_8\""));  // eight vertices

  const Outcome run_of_it = run("study boeing-random --trials 3 --set features=all --set target=" +
                                path("box/target.toml") + " --out " + path("run"));
  EXPECT_EQ(run_of_it.exit_code, 0) << run_of_it.output;

  const Outcome again = run(propose);
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.output, HasSubstr("exists already"));
  EXPECT_EQ(read_whole(path("box/target.toml")), target);
  EXPECT_EQ(run("target " + mesh.string() + " --unit furlong").exit_code, 1);
  EXPECT_EQ(run("target cube --unit mm").exit_code, 1);
  EXPECT_EQ(run("target " + mesh.string() + " --propose " + path("box/x.toml")).exit_code, 1);
}

TEST_F(Program, AMeshWithNothingToProposeSaysSo) {
  const auto strip = folder_.write(
      "strip.obj", "v 0 0 0\nv 1 0 0\nv 0.5 0.001 0\nf 1 2 3\n");  // its corners are too narrow
  const Outcome outcome = run("target " + strip.string() + " --propose " + path("strip"));
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.output, HasSubstr("nothing to propose"));
  EXPECT_FALSE(fs::exists(path("strip")));
}

TEST_F(Program, AnInterruptThatItsParentIgnoresIsIgnored) {
  const Outcome outcome = run("study boeing-table1 --trials 30 --quiet --out " + path("run") +
                              " & pid=$!; sleep 0.3; kill -INT $pid; wait $pid; echo exit $?");
  EXPECT_THAT(outcome.output, HasSubstr("exit 0\n"));
  EXPECT_TRUE(fs::exists(path("run")));
}

TEST_F(Program, AnInterruptLeavesNoRunThatSeemsWhole) {
  // SIGTERM to the program after a second, while it draws 4000 images in two processes. (A shell
  // without a terminal has what it starts with & ignore SIGINT.)
  const Outcome outcome =
      run("study boeing-table1 --trials 1000 --jobs 2 --quiet --out " + path("run") +
          " & pid=$!; sleep 1; kill -TERM $pid; wait $pid; echo exit $?");
  EXPECT_THAT(outcome.output, HasSubstr("interrupted"));
  EXPECT_THAT(outcome.output, HasSubstr("exit 130"));
  EXPECT_FALSE(fs::exists(path("run")));
}

}  // namespace
}  // namespace sightline
