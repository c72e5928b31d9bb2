// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Processes that are asked one question at a time, well-behaved or not.
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/doors/child_program.h"
#include "eval/doors/external_solver.h"
#include "scenes/files/input_error.h"
#include "tests/scenes/error_text.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int64_t kBadTrial = 2;  // in which the client has its mood

class Processes : public testing::Test {
 protected:
  static ProcessSource source(const std::string& command) {
    ProcessSource source;
    source.name = "mine";
    source.command = command;
    return source;
  }
  static std::string moody(const std::string& mood) {
    return fmt::format("python3 '{}/tests/eval/doors/moody_client.py' {}", SIGHTLINE_SOURCE_DIR,
                       mood);
  }
  // A solver that a run has begun.
  TrialSolver begun(const ProcessSource& source) const {
    TrialSolver solver = external_solver(source);
    solver.process->begin({folder_.path(), folder_.path(), 0});
    return solver;
  }
  static SolverAnswer ask(const TrialSolver& solver, int64_t trial, size_t points = 2) {
    PoseProblem problem;
    std::vector<std::string> features;
    for (size_t i = 0; i < points; ++i) {
      problem.points_in_target.emplace_back(static_cast<double>(i), 0.1, 0);
      problem.pixels.emplace_back(static_cast<double>(i), 3);
      features.push_back(fmt::format("f{}", i));
    }
    return solver.solve({problem, SolverOptions{}, features, {.trial = trial}});
  }
  std::string log() const { return read_whole(folder_.path() / "solver-mine.log"); }

  TemporaryFolder folder_;
};

TEST_F(Processes, AGoodOneIsASolver) {
  const TrialSolver solver = begun(source(moody("good")));
  for (const int64_t trial : {0, 1, 2, 3}) {
    const SolverAnswer answer = ask(solver, trial);
    ASSERT_EQ(answer.outcome, EstimateOutcome::kOk);
    EXPECT_EQ(answer.estimate.cam_from_target.translation, Eigen::Vector3d(0, 0, 10));
    EXPECT_THAT(answer.estimate.removed, ElementsAre(0));
  }
  EXPECT_EQ(log(), "I am good\n") << "it is started once, and only its own words are there";
}

TEST_F(Processes, TheReferenceClientOfCxxIsOneToo) {
  const TrialSolver solver = begun(source(SIGHTLINE_CLIENT));
  EXPECT_EQ(ask(solver, 0).outcome, EstimateOutcome::kNoEstimate);
  EXPECT_THAT(log(), HasSubstr("trial 0: no estimate: there is no initial pose"));
  PoseProblem problem;
  Pose initial;
  initial.rotation =
      Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  initial.translation = {0.1, 1.0 / 3, 1e-300};
  problem.initial_cam_from_target = initial;
  const SolverAnswer answer = solver.solve({problem, SolverOptions{}, {}, {}});
  ASSERT_EQ(answer.outcome, EstimateOutcome::kOk);
  EXPECT_EQ(answer.estimate.cam_from_target.rotation, initial.rotation) << "bit by bit";
  EXPECT_EQ(answer.estimate.cam_from_target.translation, initial.translation);
}

struct Mood {
  std::string name;
  EstimateOutcome outcome;
  std::string reason;  // in the log
  bool is_restarted;
};

TEST_F(Processes, AFailureIsAStatusWithAReasonAndTheNextTrialIsAsked) {
  const std::vector<Mood> moods = {
      {"crash", EstimateOutcome::kCrashed, "it ended before it answered", true},
      {"hang", EstimateOutcome::kTimedOut, "it did not answer within 3 s", true},
      {"garble", EstimateOutcome::kGarbled, "its answer is 'my pose is fine'", true},
      {"huge", EstimateOutcome::kGarbled, "it answered with more than 16777216 bytes", true},
      {"stale", EstimateOutcome::kGarbled, "has not the id", true},
      {"moon", EstimateOutcome::kGarbled, "has the status 'full moon', must be one of ok", true},
      {"stranger", EstimateOutcome::kGarbled, "names the feature 'nose'", true},
      {"unsure", EstimateOutcome::kGarbled, "has a covariance with a variance that", true},
      {"infinite", EstimateOutcome::kGarbled, "Infinity", true},
      {"abyss", EstimateOutcome::kGarbled, "is nested deeper than 100", true},
      {"raise", EstimateOutcome::kRaisedError, "raised an error: the network is tired", false},
      {"none", EstimateOutcome::kNoEstimate, "trial 2: no estimate", false},
      {"long", EstimateOutcome::kNotRigid, "trial 2: not rigid", false},
  };
  for (const Mood& mood : moods) {
    SCOPED_TRACE(mood.name);
    fs::remove(folder_.path() / "solver-mine.log");
    ProcessSource given = source(moody(mood.name));
    given.timeout_s = mood.name == "hang" ? 3 : 60;
    const TrialSolver solver = begun(given);
    EXPECT_EQ(ask(solver, 1).outcome, EstimateOutcome::kOk);
    EXPECT_EQ(ask(solver, kBadTrial).outcome, mood.outcome);
    EXPECT_EQ(ask(solver, 3).outcome, EstimateOutcome::kOk);
    EXPECT_THAT(log(), HasSubstr(mood.reason));
    const std::string start = "I am " + mood.name;
    const std::string text = log();
    EXPECT_EQ(text.rfind(start) != text.find(start), mood.is_restarted);
  }
}

// More than its input's buffer holds, and the process reads none of it.
TEST_F(Processes, OneThatDoesNotReadIsNoHang) {
  const fs::path deaf = folder_.write("deaf.py",
                                      "import time\n"
                                      "input()\n"
                                      "print('{\"protocol\": 1}', flush=True)\n"
                                      "time.sleep(1000)\n");
  ProcessSource given = source("python3 " + deaf.string());
  given.timeout_s = 0.5;
  EXPECT_EQ(ask(begun(given), 0, 100'000).outcome, EstimateOutcome::kTimedOut);
}

TEST_F(Processes, ALateStartIsWaitedFor) {
  ProcessSource given = source(moody("late"));
  given.timeout_s = 1;  // shorter than the start
  EXPECT_EQ(ask(begun(given), 0).outcome, EstimateOutcome::kOk);
  given.start_timeout_s = 0.1;
  EXPECT_THAT(error_of([&] { ask(begun(given), 0); }),
              HasSubstr("when asked for its hello it did not answer within 0.1 s"));
}

TEST_F(Processes, OneThatNeverSaysHelloIsAnError) {
  EXPECT_THAT(error_of([&] { ask(begun(source(moody("still-born"))), 0); }),
              AllOf(HasSubstr("external.solver mine"), HasSubstr("ended before it answered"),
                    HasSubstr("its last words: there is no network here")));
  EXPECT_THAT(error_of([&] { ask(begun(source(moody("newer"))), 0); }),
              AllOf(HasSubstr("says hello with '{\"protocol\": 7}'"),
                    HasSubstr("must be {\"protocol\": 1}")));
}

TEST_F(Processes, OnlyProgramsThatAreThereCanBeStarted) {
  EXPECT_THAT(
      error_of([&] { external_solver(source("no-such-program a")).process->require_program(); }),
      HasSubstr("there is no program 'no-such-program' in PATH"));
  EXPECT_THAT(error_of([&] { external_solver(source("/etc/passwd")).process->require_program(); }),
              HasSubstr("/etc/passwd is no program that may be run"));
  EXPECT_NO_THROW(external_solver(source("python3 a")).process->require_program());
  EXPECT_THAT(error_of([&] { external_solver(source("python3 'a")); }),
              HasSubstr("must close its quote '"));
  EXPECT_THAT(error_of([&] { external_solver(source(" ")); }), HasSubstr("is empty"));
}

TEST_F(Processes, ACommandIsPartedAsInAShellButSeenByNone) {
  EXPECT_THAT(words_of_command(R"(a  'b c' "d 'e" f\ g '' $HOME;x)"),
              ElementsAre("a", "b c", "d 'e", "f g", "", "$HOME;x"));
}

TEST_F(Processes, NothingIsStartedUnlessARunBegan) {
  const std::string marker = (folder_.path() / "started").string();
  const TrialSolver solver = external_solver(source(moody("good started=" + marker)));
  EXPECT_THAT(error_of([&] { ask(solver, 0); }), HasSubstr("only a run asks it"));
  EXPECT_FALSE(fs::exists(marker));
  solver.process->begin({folder_.path(), folder_.path(), 0});
  EXPECT_EQ(ask(solver, 0).outcome, EstimateOutcome::kOk);
  EXPECT_TRUE(fs::exists(marker));
  solver.process->end();
  EXPECT_THAT(error_of([&] { ask(solver, 0); }), HasSubstr("only a run asks it"));
}

// The number that a file tells, once it does.
pid_t number_in(const fs::path& file) {
  pid_t number = 0;
  for (int i = 0; i < 1000 && !(std::ifstream(file) >> number); ++i) usleep(10'000);
  return number;
}

// It ends at once or, where the system is slow, soon.
bool has_ended(pid_t process) {
  for (int i = 0; i < 500; ++i) {
    if (kill(process, 0) != 0) return true;
    usleep(10'000);
  }
  return false;
}

TEST_F(Processes, ItsOwnChildrenEndWithIt) {
  const fs::path child = folder_.path() / "child";
  const fs::path parent =
      folder_.write("parent.py", fmt::format("import subprocess\n"
                                             "child = subprocess.Popen(['sleep', '1000'])\n"
                                             "print(child.pid, file=open('{}', 'w'))\n"
                                             "input()\n"
                                             "print('{{\"protocol\": 1}}', flush=True)\n"
                                             "input()\n",
                                             child.string()));
  const TrialSolver solver = begun(source("python3 " + parent.string()));
  EXPECT_EQ(ask(solver, 0).outcome, EstimateOutcome::kCrashed);
  const pid_t grandchild = number_in(child);
  ASSERT_GT(grandchild, 0);
  EXPECT_TRUE(has_ended(grandchild));
}

}  // namespace
}  // namespace sightline
