// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// tests/example/, a pipeline of somebody's own in Python and OpenCV, guarded by the commands that a
// CI job runs.
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/eval/program.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kPython = "/usr/bin/python3";  // Debian's, which has its python3-opencv

TEST(ExamplePipeline, IsGuarded) {
  if (run_shell(std::string(kPython) + " -c 'import cv2, numpy'").exit_code != 0) {
    GTEST_SKIP() << "Debian's python3-opencv is not installed";
  }
  const TemporaryFolder folder;
  const auto guard = [&](const std::string& more) {
    return run_shell(
        std::string("PYTHON=") + kPython +
        " SIGHTLINE=" SIGHTLINE_PROGRAM " sh " SIGHTLINE_SOURCE_DIR "/tests/example/guard.sh " +
        (folder.path() / "work").string() + " " + (folder.path() / "base").string() + " " + more);
  };
  const auto again = [&](const std::string& more) {
    fs::remove_all(folder.path() / "work" / "now");
    return guard(more);
  };
  const Outcome first = guard("");
  ASSERT_EQ(first.exit_code, 0) << first.output;
  const Outcome same = again("");
  EXPECT_EQ(same.exit_code, 0) << same.output;
  EXPECT_THAT(same.output, HasSubstr("0 worse"));
  const Outcome worse = again("--unrefined");
  EXPECT_EQ(worse.exit_code, 3) << worse.output;
  EXPECT_THAT(read_whole(folder.path() / "work" / "compare.xml"), HasSubstr("<failure"));
}

}  // namespace
}  // namespace sightline
