// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Runs that are killed, interrupted, or find no room, and what continues them: real processes.
#include <chrono>
#include <fstream>
#include <map>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <signal.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include "eval/output/output_folder.h"
#include "eval/results/store.h"
#include "scenes/files/input_error.h"
#include "scenes/random/random.h"
#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

// 9 conditions of 1000 trials: a handful of batches.
const std::string kStudy = "study cube-noise --set trials=1000 --set 'solvers=[\"lspe\"]' --quiet ";
constexpr int64_t kTrialsInAll = 9000;
// A limit on a file's size (in blocks of 512 bytes) that some of these batches fit in.
const std::string kLittleRoom = "ulimit -f 7000; ";

std::string program() {
  return SIGHTLINE_PROGRAM;
}

class Resume : public testing::Test {
 protected:
  fs::path out(const std::string& name) const { return folder_.path() / name; }
  std::string to(const std::string& name) const { return "--out " + out(name).string(); }

  // The trials that a run has left beside its folder. Of a copy, so that the repair of a store
  // whose writer was killed is left to the program.
  int64_t trials_left(const std::string& name) const {
    const fs::path staging = staging_folder(out(name));
    if (!fs::exists(staging)) return 0;
    wait_for_lock(staging);
    const fs::path copy = out("copy");
    fs::remove_all(copy);
    fs::copy(staging, copy);
    int64_t count = 0;
    std::vector<bool> held(kTrialsInAll);
    for (const auto& entry : fs::directory_iterator(copy)) {
      if (entry.path().extension() != ".sqlite") continue;
      const std::vector<bool> of_store = Store::open(entry.path()).held(kTrialsInAll);
      for (size_t i = 0; i < held.size(); ++i) {
        count += of_store[i] && !held[i];  // a store may have been taken over right before the kill
        held[i] = held[i] || of_store[i];
      }
    }
    return count;
  }

  void expect_same_results(const std::string& a, const std::string& b) const {
    for (const char* file : {"results.csv", "summary.json", "study.toml"}) {
      EXPECT_EQ(read_whole(out(a) / file), read_whole(out(b) / file)) << file;
    }
  }

  // Ends with finished trials in the folder beside, for want of room.
  void run_out_of_room(const std::string& name) const {
    const Outcome outcome =
        run_shell(kLittleRoom + program() + " " + kStudy + "--jobs 1 " + to(name));
    ASSERT_EQ(outcome.exit_code, 1) << outcome.output;
    EXPECT_EQ(lines_of(outcome.output), 1u) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr("results.sqlite: cannot be written"));
    EXPECT_THAT(outcome.output, HasSubstr("finished trials are kept for --resume"));
  }

  TemporaryFolder folder_;

 private:
  // A killed run's workers hold the lock until they have ended as well.
  static void wait_for_lock(const fs::path& staging) {
    const int lock = open((staging / ".lock").c_str(), O_RDWR);
    if (lock < 0) return;
    flock(lock, LOCK_EX);
    close(lock);
  }
};

// Runs the shell's line and kills the program after so long; false if it ended before.
bool run_and_kill(const std::string& line, Clock::duration after) {
  const pid_t process = fork();
  if (process == 0) {
    execl("/bin/sh", "sh", "-c", ("exec " + line + " >/dev/null 2>&1").c_str(), nullptr);
    _exit(127);
  }
  std::this_thread::sleep_for(after);
  kill(process, SIGKILL);
  int status = 0;
  waitpid(process, &status, 0);
  return WIFSIGNALED(status);
}

TEST_F(Resume, AfterKillsAtAnyMomentLosesNothingAndRepeatsNothing) {
  const auto start = Clock::now();
  ASSERT_EQ(run(kStudy + "--jobs 1 " + to("whole")).exit_code, 0);
  const auto whole = Clock::now() - start;

  constexpr int kLeastKills = 6;
  RandomStream random(std::random_device{}(), "kills", 0);
  int kills = 0;
  int kills_between = 0;  // that left finished trials
  for (int round = 0; kills < kLeastKills || kills_between == 0; ++round) {
    ASSERT_LT(round, 20) << "no kill hits";
    const std::string name = fmt::format("round-{}", round);
    int64_t left = 0;
    while (true) {
      const int jobs = 1 + static_cast<int>(3 * random.uniform());
      const double part = random.uniform(0.05, 0.7);
      const auto after = std::chrono::duration_cast<Clock::duration>(part * whole);
      SCOPED_TRACE(
          fmt::format("round {}, kill after {:.2f} of the whole, {} jobs", round, part, jobs));
      const std::string line = program() + " " + kStudy + to(name);
      if (!run_and_kill(fmt::format("{} --resume --jobs {}", line, jobs), after)) break;
      if (fs::exists(out(name))) break;  // killed when all was done
      ++kills;
      const int64_t now_left = trials_left(name);
      EXPECT_GE(now_left, left) << "a finished batch was lost";
      left = now_left;
      kills_between += left > 0;
    }
    ASSERT_EQ(run(kStudy + to(name) + " --resume").exit_code, 0);
    const auto manifest = nlohmann::json::parse(read_whole(out(name) / "manifest.json"));
    EXPECT_GE(manifest.value("resumed_trials", int64_t{0}), left) << "a trial was repeated";
    expect_same_results("whole", name);
    EXPECT_FALSE(fs::exists(staging_folder(out(name))));
    EXPECT_FALSE(fs::exists(out(name) / ".lock"));
  }
}

TEST_F(Resume, WithoutRoomEndsInOneLineWithTheStoreIntactAndContinuesWhereThereIsRoom) {
  ASSERT_EQ(run(kStudy + "--jobs 1 " + to("whole")).exit_code, 0);
  run_out_of_room("run");
  const int64_t left = trials_left("run");
  EXPECT_GT(left, 0);
  EXPECT_LT(left, kTrialsInAll);
  EXPECT_FALSE(fs::exists(out("run")));
  ASSERT_EQ(run(kStudy + to("run") + " --resume --jobs 2").exit_code, 0);
  const auto manifest = nlohmann::json::parse(read_whole(out("run") / "manifest.json"));
  EXPECT_EQ(manifest["resumed_trials"], left);
  expect_same_results("whole", "run");
}

TEST_F(Resume, RefusesARunOfAnotherKindAndKeepsWhatIsThere) {
  run_out_of_room("run");
  const int64_t left = trials_left("run");
  const std::string resumed = kStudy + to("run") + " --resume ";
  const std::vector<std::pair<std::string, std::string>> refusals = {
      {resumed + "--seed 2", "was begun with seed 1, not 2"},
      {resumed + "--gl egl", "was begun with gl none, not egl"},
      {resumed + "--shard 0/2", "was begun with shard 0/1, not 0/2"},
      {resumed + "--set noise.scale=2", "was begun with other keys of the study cube-noise"},
      {resumed + "--trials 400", "was begun with trials 9000, not 3600"},
      {"study cube-outliers --resume --quiet " + to("run"), "was begun with study cube-noise"},
      {kStudy + to("run"), "an ended run left"}};  // without --resume
  for (const auto& [arguments, reason] : refusals) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 1) << arguments;
    EXPECT_EQ(lines_of(outcome.output), 1u) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr(reason));
  }
  EXPECT_EQ(trials_left("run"), left);
}

TEST_F(Resume, OfACompleteRunDoesNothing) {
  ASSERT_EQ(run(kStudy + to("run")).exit_code, 0);
  const std::string manifest = read_whole(out("run") / "manifest.json");
  EXPECT_EQ(run(kStudy + to("run") + " --resume").exit_code, 0);
  EXPECT_EQ(read_whole(out("run") / "manifest.json"), manifest);
  const Outcome other = run(kStudy + to("run") + " --resume --seed 2");
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.output, HasSubstr("was begun with seed 1, not 2"));
}

TEST_F(Resume, NeedsToBeToldWhere) {
  EXPECT_EQ(run("study cube-noise --resume").exit_code, 2);
}

TEST_F(Resume, TwoRunsIntoOneFolderAreRefused) {
  const std::string study = kStudy + "--trials 1000000 --resume " + to("run");
  const pid_t first = fork();
  if (first == 0) {
    execl("/bin/sh", "sh", "-c", ("exec " + program() + " " + study).c_str(), nullptr);
    _exit(127);
  }
  while (!fs::exists(staging_folder(out("run")) / "results.sqlite")) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  for (const char* how : {" --jobs 1", " --jobs 2"}) {
    const Outcome second = run(study + how);
    EXPECT_EQ(second.exit_code, 1);
    EXPECT_EQ(lines_of(second.output), 1u) << second.output;
    EXPECT_THAT(second.output, HasSubstr("another run is writing it"));
  }
  kill(first, SIGKILL);
  waitpid(first, nullptr, 0);
}

TEST_F(Resume, AnInterruptKeepsFinishedTrialsWhetherTheRunWasToBeResumedOrNot) {
  const auto interrupted = [&](const std::string& name, const std::string& how) {
    // Wait for a first batch in a worker's store: it is far larger than an empty one then, and has
    // no journal between transactions.
    const std::string staging = staging_folder(out(name)).string();
    return run_shell(program() + " " + kStudy + "--trials 100000 --jobs 2 " + to(name) + how +
                     " & pid=$!; until f=$(find " + staging +
                     " -name 'job-*.sqlite' -size +100k 2>/dev/null | head -1); [ -n \"$f\" ] && "
                     "[ ! -e $f-journal ]; do sleep 0.01; done; "
                     "kill -TERM $pid; wait $pid; echo exit $?");
  };
  for (const std::string how : {" --resume", ""}) {
    const std::string name = how.empty() ? "plain" : "resumed";
    const Outcome kept = interrupted(name, how);
    EXPECT_THAT(kept.output, HasSubstr("kept for --resume"));
    EXPECT_THAT(kept.output, HasSubstr("exit 130"));
    EXPECT_TRUE(fs::exists(staging_folder(out(name))));
    EXPECT_FALSE(fs::exists(out(name)));
  }
}

TEST_F(Resume, AMergeThatWasKilledIsRepeated) {
  for (const std::string shard : {"0", "1"}) {
    ASSERT_EQ(run(kStudy + to("shard-" + shard) + " --shard " + shard + "/2").exit_code, 0);
  }
  const std::string merge = "merge " + out("shard-0").string() + " " + out("shard-1").string() +
                            " --out " + out("merged").string();
  const fs::path staging = staging_folder(out("merged"));
  const auto leave = [&](const std::map<std::string, std::string>& meta) {
    fs::create_directories(staging);
    std::ofstream(staging / ".lock").close();
    TrialRecord trial;
    Store::create(staging / "results.sqlite", meta).add(std::span(&trial, 1));
  };
  leave({{"merged", "2"}});
  const Outcome repeated = run(merge);
  EXPECT_EQ(repeated.exit_code, 0) << repeated.output;
  EXPECT_FALSE(fs::exists(staging));
  fs::remove_all(out("merged"));

  leave({});  // of a run, whose trials nobody else has
  const Outcome refused = run(merge);
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.output, HasSubstr("an ended run left"));
  EXPECT_TRUE(fs::exists(staging / "results.sqlite"));
}

TEST_F(Resume, AFolderThatCannotBeWrittenIsOneLine) {
  // Root may write everywhere, so that the program is run as nobody.
  const std::string as_nobody =
      geteuid() == 0 ? "setpriv --reuid=65534 --regid=65534 --clear-groups " : "";
  fs::permissions(folder_.path(), fs::perms::others_exec, fs::perm_options::add);
  fs::create_directories(out("locked"));
  fs::permissions(out("locked"), fs::perms::owner_read | fs::perms::owner_exec |
                                     fs::perms::others_read | fs::perms::others_exec);
  if (run_shell(as_nobody + program() + " --version").exit_code != 0) {
    GTEST_SKIP() << "nobody may not run the program here";
  }
  const Outcome outcome =
      run_shell(as_nobody + program() + " " + kStudy + to("locked/run") + " --resume");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(lines_of(outcome.output), 1u) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("cannot be written (Permission denied)"));
  fs::permissions(out("locked"), fs::perms::owner_all);
  EXPECT_TRUE(fs::is_empty(out("locked")));
}

}  // namespace
}  // namespace sightline
