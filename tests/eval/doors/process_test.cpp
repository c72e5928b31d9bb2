// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whole runs that ask processes, through the program as a user runs it.
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/output/csv_reader.h"
#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class AskedProcess : public testing::Test {
 protected:
  static constexpr int kTrials = 4;

  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  static std::string moody(const std::string& mood_and_more) {
    return fmt::format("python3 {}/tests/eval/doors/moody_client.py {}", SIGHTLINE_SOURCE_DIR,
                       mood_and_more);
  }
  static std::string solver(const std::string& mood_and_more) {
    return fmt::format(" --solver mine='{}'", moody(mood_and_more));
  }
  static std::string extractor(const std::string& mood_and_more) {
    return fmt::format(" --extractor net='{}'", moody(mood_and_more));
  }
  // Four trials of five corners of a rendered 707.
  Outcome study(const std::string& out, const std::string& more) const {
    return run(
        fmt::format("study boeing-random --trials {} --seed 4 --quiet --out {} "
                    "--set \"solvers=['lspe']\" {}",
                    kTrials, path(out), more));
  }
  // The rows of a run by solver and trial, each a value of that column.
  std::map<std::string, std::vector<std::string>> column(const std::string& out,
                                                         const std::string& name) const {
    std::map<std::string, std::vector<std::string>> values;
    for (CsvReader csv(path(out) + "/results.csv"); csv.next();) {
      values[std::string(csv.text("solver"))].emplace_back(csv.text(name));
    }
    return values;
  }
  std::string results(const std::string& out) const {
    return read_whole(path(out) + "/results.csv");
  }

  TemporaryFolder folder_;
};

TEST_F(AskedProcess, ThatAnswersAsABuiltInDoesIsItsEqual) {
  ASSERT_EQ(study("own", "").exit_code, 0);
  const Outcome outcome = study("asked", solver("good poses=" + path("own") + "/results.csv"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  auto errors = column("asked", "theta_error_deg");
  ASSERT_EQ(errors["mine"].size(), static_cast<size_t>(kTrials));
  constexpr double kPrintedDigits = 1e-6;  // deg
  for (size_t i = 0; i < kTrials; ++i) {
    EXPECT_NEAR(std::stod(errors["mine"][i]), std::stod(errors["lspe"][i]), kPrintedDigits);
  }
  EXPECT_EQ(read_whole(path("asked") + "/logs/solver-mine.log"), "I am good\n");
}

TEST_F(AskedProcess, ThatFailsInATrialIsRestartedForTheNextInAnyNumberOfJobs) {
  const std::map<std::string, std::string> status = {
      {"crash", "process ended"}, {"skewed", "not rigid"}, {"raise", "raised an error"}};
  for (const auto& [mood, expected] : status) {
    SCOPED_TRACE(mood);
    const Outcome outcome = study(mood, solver(mood));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    const std::vector<std::string> ok = {"ok", "ok", expected, "ok"};
    EXPECT_EQ(column(mood, "status")["mine"], ok);
    EXPECT_EQ(column(mood, "status")["lspe"], std::vector<std::string>(kTrials, "ok"));
  }
  const Outcome outcome = study("two", solver("crash") + " --jobs 2");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(results("two"), results("crash"));
  EXPECT_EQ(read_whole(path("two") + "/summary.json"), read_whole(path("crash") + "/summary.json"));
  EXPECT_THAT(read_whole(path("two") + "/logs/solver-mine.log"),
              HasSubstr("sightline: trial 2: process ended"));
  EXPECT_EQ(read_whole(path("two") + "/logs/solver-mine-1.log"), "I am crash\n");
}

TEST_F(AskedProcess, ThatHangsIsAFailedTrial) {
  const Outcome outcome =
      study("run", solver("hang") + " --set external.solver.0.timeout_s=3 --jobs 2");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(column("run", "status")["mine"],
            (std::vector<std::string>{"ok", "ok", "timed out", "ok"}));
  EXPECT_THAT(read_whole(path("run") + "/summary.json"), HasSubstr("\"failures\": 1"));
}

TEST_F(AskedProcess, MayBeAnExtractorBesideOthers) {
  const Outcome outcome = study(
      "run", extractor("garble images=" + path("images") + " a,b=c") + " --extractor by_kind");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  std::map<std::string, std::vector<std::string>> status;
  for (CsvReader csv(path("run") + "/results.csv"); csv.next();) {
    status[std::string(csv.text("extractor"))].emplace_back(csv.text("status"));
  }
  // The trials of a draw follow one another: that of number 2 is the process's second.
  const std::vector<std::string> expected = {"ok", "answer unreadable", "ok", "ok"};
  EXPECT_EQ(status["net"], expected);
  EXPECT_EQ(status["by_kind"], std::vector<std::string>(kTrials, "ok"));
  std::istringstream images(read_whole(path("images")));
  int count = 0;
  for (std::string image; std::getline(images, image); ++count) {
    EXPECT_FALSE(fs::exists(image)) << "it is there only until it is answered";
    EXPECT_FALSE(fs::exists(fs::path(image).parent_path()));
  }
  EXPECT_EQ(count, kTrials - 1);
  EXPECT_THAT(read_whole(path("run") + "/report.html"), HasSubstr("moody_client.py"));
}

TEST_F(AskedProcess, ReadsThePicturesOfADataSetWhereTheyAre) {
  ASSERT_EQ(run("render cube --count 3 --seed 5 --quiet --out " + path("set")).exit_code, 0);
  const Outcome outcome = run(
      fmt::format("evaluate {} --target cube --solvers lspe --jobs 1 --quiet --out {} --extractor "
                  "'net=python3 {}/docs/clients/client.py' --solver 'mine={}' --solver 'other={}'",
                  path("set"), path("run"), SIGHTLINE_SOURCE_DIR, SIGHTLINE_CLIENT,
                  moody("good started=" + path("started"))));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const auto status = column("run", "status");
  ASSERT_EQ(status.size(), 3u);
  for (const auto& [name, of_trials] : status) {
    EXPECT_EQ(of_trials, std::vector<std::string>(3, "ok")) << name;
  }
  EXPECT_EQ(lines_of(read_whole(path("started"))), 1u) << "the report starts none";
  const Outcome pictures =
      run(fmt::format("evaluate {} --target cube --solvers lspe --quiet --out {} {}", path("set"),
                      path("again"), extractor("good images=" + path("images"))));
  ASSERT_EQ(pictures.exit_code, 0) << pictures.output;
  EXPECT_THAT(read_whole(path("images")), HasSubstr(path("set")));
}

TEST_F(AskedProcess, ANumericStudyAsksItToo) {
  const Outcome outcome =
      run("study cube-noise --trials 2 --quiet --set 'solver.start=prior' "
          "--set 'sweep.noise_px=[1]' --set \"solvers=['lspe']\" --out " +
          path("run") + solver("good"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(column("run", "status")["mine"], std::vector<std::string>(2, "ok"));
}

// A folder that somebody sent names commands: only a run may start them.
TEST_F(AskedProcess, IsNotStartedByReportMergeAndCompare) {
  const std::string marker = path("started");
  const std::string both = solver("crash started=" + marker) + extractor("good started=" + marker);
  ASSERT_EQ(study("whole", both).exit_code, 0);
  ASSERT_EQ(study("a", both + " --shard 0/2").exit_code, 0);
  ASSERT_EQ(study("b", both + " --shard 1/2").exit_code, 0);
  ASSERT_TRUE(fs::remove(marker)) << "the runs started it";
  const std::string before = results("whole");
  ASSERT_TRUE(fs::remove(path("whole") + "/report.html"));

  const Outcome reported = run("report " + path("whole"));
  ASSERT_EQ(reported.exit_code, 0) << reported.output;
  EXPECT_EQ(results("whole"), before);
  EXPECT_THAT(read_whole(path("whole") + "/report.html"),
              AllOf(HasSubstr("data:image/png"), Not(HasSubstr("re-run differs"))));
  const Outcome merged =
      run(fmt::format("merge {} {} --out {}", path("a"), path("b"), path("merged")));
  ASSERT_EQ(merged.exit_code, 0) << merged.output;
  EXPECT_EQ(results("merged"), results("whole"));
  EXPECT_EQ(run(fmt::format("compare {} {}", path("whole"), path("merged"))).exit_code, 0);
  const Outcome resumed = study("whole", both + " --resume");
  EXPECT_EQ(resumed.exit_code, 0) << resumed.output;
  EXPECT_FALSE(fs::exists(marker));
}

TEST_F(AskedProcess, ThatCannotBeStartedIsSaidBeforeAnyWork) {
  const Outcome absent = study("run", " --solver mine='no-such-program --x'");
  EXPECT_EQ(absent.exit_code, 1);
  EXPECT_THAT(absent.output, AllOf(HasSubstr("external.solver mine (no-such-program --x)"),
                                   HasSubstr("there is no program 'no-such-program' in PATH")));
  const Outcome dead = study("run", solver("still-born") + " --jobs 2");
  EXPECT_EQ(dead.exit_code, 1);
  EXPECT_THAT(dead.output, HasSubstr("its last words: there is no network here"));
  EXPECT_EQ(lines_of(dead.output), 1u) << dead.output;
  EXPECT_THAT(study("run", " --solver python3").output, HasSubstr("must be NAME=COMMAND"));
  EXPECT_THAT(study("run", " --solver orpe=python3").output,
              HasSubstr("is another's name already"));
  EXPECT_THAT(study("run", " --solver mine='a \"b'").output,
              AllOf(HasSubstr("external.solver"), HasSubstr("must close its quote")));
  for (const auto& entry : fs::directory_iterator(folder_.path())) ADD_FAILURE() << entry.path();
}

// Ends the program in the midst of a trial that hangs. Prints whether the hanging process is left.
TEST_F(AskedProcess, EndsWithTheProgramHoweverThatEnds) {
  for (const std::string signal : {"TERM", "KILL"}) {
    for (const std::string jobs : {"1", "2"}) {
      SCOPED_TRACE(signal + " " + jobs);
      const std::string started = path("started-" + signal + jobs);
      // A shell stands between, which the process outlives where nobody sees to it.
      const Outcome outcome = run_shell(fmt::format(
          "{} study boeing-random --trials 4 --quiet --jobs {} --out {} --set \"solvers=['lspe']\" "
          "--solver mine='sh -c \"{}; true\"' > {} 2>&1 & program=$!; "
          "for i in $(seq 1000); do grep -qs hang {}/.run-{}{}.partial/logs/*.log && break; "
          "sleep 0.05; done; sleep 0.5; kill -{} $program; wait $program; "
          "for process in $(cat {}); do for i in $(seq 100); do "
          "kill -0 $process 2>/dev/null || break; sleep 0.05; done; "
          "kill -0 $process 2>/dev/null && echo left; done; echo checked",
          SIGHTLINE_PROGRAM, jobs, path("run-" + signal + jobs), moody("hang started=" + started),
          path("output"), folder_.path().string(), signal, jobs, signal, started));
      EXPECT_THAT(outcome.output, AllOf(HasSubstr("checked"), Not(HasSubstr("left"))));
      EXPECT_GE(lines_of(read_whole(started)), 1u);
    }
  }
}

}  // namespace
}  // namespace sightline
