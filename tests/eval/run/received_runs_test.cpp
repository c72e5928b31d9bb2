// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Folders of runs that somebody sent, made to do harm or damaged.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ReceivedRun : public testing::Test {
 protected:
  void make_run(const std::string& name, int trials) const {
    const Outcome outcome =
        run(fmt::format("study cube-outliers --quiet --trials {} --set 'solvers=[\"lspe\"]' "
                        "--out {}/{}",
                        trials, folder_.path().string(), name));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  }

  TemporaryFolder folder_;
};

// What is wrong with a shard is said of it and not of the copy, which is gone by then; and no more
// than a line of what stands there.
TEST_F(ReceivedRun, IsNamedByAMergeWhereItIsWrong) {
  const std::string path = folder_.path().string();
  make_run("0", 2);
  for (const char* sql :
       {"UPDATE estimates SET geodesic_deg = -1 WHERE trial = 1",
        "UPDATE estimates SET status = printf('%.*c', 5000000, 'x') WHERE trial = 1",
        "UPDATE trials SET trial = -1 WHERE trial = 1"}) {
    fs::remove_all(path + "/1");
    fs::copy(path + "/0", path + "/1", fs::copy_options::recursive);
    SQLite::Database(path + "/1/results.sqlite", SQLite::OPEN_READWRITE).exec(sql);
    const Outcome outcome = run(fmt::format("merge {0}/1 --out {0}/merged", path));
    EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr("/1/results.sqlite: ")) << sql;
    EXPECT_LT(outcome.output.size(), 1000u) << sql;
  }
}

// Not where the disk is full: shards are not read whole for what they are not to blame for.
TEST_F(ReceivedRun, IsNotBlamedForTheDisk) {
  const std::string path = folder_.path().string(), store = path + "/0/results.sqlite";
  make_run("0", 300);
  SQLite::Database(store, SQLite::OPEN_READWRITE)
      .exec("UPDATE estimates SET geodesic_deg = -1 WHERE trial = 1");
  constexpr uintmax_t kUnitBytes = 512;  // of the shell's limit
  const uintmax_t half = fs::file_size(store) / 2 / kUnitBytes;
  const Outcome outcome = run_shell(fmt::format("ulimit -f {}; {} merge {}/0 --out {}/merged", half,
                                                SIGHTLINE_PROGRAM, path, path));
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("/.merged.partial/results.sqlite: cannot be written"));
}

// A folder of others may have links where figures are drawn: nothing is written through them.
TEST_F(ReceivedRun, HasNothingWrittenThroughItsLinks) {
  const std::string path = folder_.path().string();
  make_run("run", 2);
  const fs::path figures = path + "/run/figures", victim = path + "/victim";
  const auto report = [&] {
    const Outcome outcome = run("report " + path + "/run");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  };
  std::ofstream(victim) << "precious";
  std::vector<fs::path> drawn;
  for (const auto& entry : fs::directory_iterator(figures)) drawn.push_back(entry.path());
  ASSERT_FALSE(drawn.empty());
  for (const fs::path& file : drawn) {
    fs::remove(file);
    fs::create_symlink(victim, file);
  }
  report();
  EXPECT_EQ(read_whole(victim), "precious");
  fs::remove_all(figures);
  fs::create_directories(path + "/elsewhere");
  fs::create_directory_symlink(path + "/elsewhere", figures);
  report();
  EXPECT_TRUE(fs::is_empty(path + "/elsewhere"));
  EXPECT_FALSE(fs::is_symlink(figures));
  EXPECT_FALSE(fs::is_empty(figures));
}

// A report shows the manifest: not any JSON of the user's that a link leads to.
TEST_F(ReceivedRun, ShowsNoManifestThatALinkLeadsTo) {
  const std::string path = folder_.path().string();
  make_run("run", 2);
  const fs::path manifest = path + "/run/manifest.json";
  const auto page = [&](const fs::path& at) {
    std::ofstream(at) << R"({"token": "hunter2"})";
    EXPECT_EQ(run("report " + path + "/run").exit_code, 0);
    return read_whole(path + "/run/report.html");
  };
  EXPECT_THAT(page(manifest), HasSubstr("hunter2"));
  fs::remove(manifest);
  fs::create_symlink(path + "/secret.json", manifest);
  EXPECT_THAT(page(path + "/secret.json"), testing::Not(HasSubstr("hunter2")));
}

}  // namespace
}  // namespace sightline
