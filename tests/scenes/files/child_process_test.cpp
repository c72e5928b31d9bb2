// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/files/child_process.h"

#include <string>

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include "scenes/files/pauses.h"
#include "tests/scenes/temporary_folder.h"

namespace sightline {
namespace {

std::string read_to_end(int file) {
  std::string text;
  char buffer[4096];
  for (ssize_t size = 0; (size = read(file, buffer, sizeof buffer)) > 0;) text.append(buffer, size);
  return text;
}

TEST(ChildProcess, WritesToItsParentAndEndsWithItsExitCode) {
  const std::string long_text(300'000, 'x');  // more than a pipe holds
  const ChildProcess child = fork_child([&](int pipe) {
    write_all(pipe, long_text);
    return 7;
  });
  EXPECT_EQ(read_to_end(child.pipe), long_text);
  close(child.pipe);
  const ProcessEnd end = wait_for(child.process);
  EXPECT_EQ(end.signal, 0);
  EXPECT_EQ(end.exit_code, 7);
  EXPECT_FALSE(end.is_good());
}

TEST(ChildProcess, ASignalThatEndsItIsKnown) {
  const ChildProcess child = fork_child([](int) { return raise(SIGKILL); });
  close(child.pipe);
  const ProcessEnd end = wait_for(child.process);
  EXPECT_EQ(end.signal, SIGKILL);
  EXPECT_FALSE(end.is_good());
}

// A child forks a grandchild that would never end, and is killed: the pipe, of which the grandchild
// holds the last writing end, closes only when that ends too.
TEST(ChildProcess, EndsWithItsParent) {
  const ChildProcess child = fork_child([](int pipe) {
    fork_child([](int) { return pause(); });
    write_all(pipe, "forked");
    return pause();
  });
  char text[6];
  EXPECT_EQ(read(child.pipe, text, sizeof text), 6);
  kill(child.process, SIGKILL);
  EXPECT_EQ(wait_for(child.process).signal, SIGKILL);
  EXPECT_EQ(read_to_end(child.pipe), "");
  close(child.pipe);
}

TEST(RunProgram, RunsInTheFolderAndGivesTheExitCode) {
  const TemporaryFolder folder;
  EXPECT_EQ(run_program({"sh", "-c", "pwd > here; exit 3"}, folder.path()), 3);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "here"));
  EXPECT_EQ(run_program({"sh", "-c", "kill -9 $$"}, folder.path()), -1);
}

// Without it a program that hangs would hold whoever waits for it, whatever signal comes.
TEST(RunProgram, IsEndedByWhatIsThrownInAPause) {
  const TemporaryFolder folder;
  struct HeardASignal {};
  static std::filesystem::path begun;
  begun = folder.path() / "begun";
  call_in_pauses([] {
    if (std::filesystem::exists(begun)) throw HeardASignal();
  });
  EXPECT_THROW(
      run_program({"sh", "-c", "echo $$ > pid; mv pid begun; exec sleep 1000"}, folder.path()),
      HeardASignal);
  call_in_pauses(nullptr);
  EXPECT_EQ(kill(std::stoi(read_whole(begun)), 0), -1);  // it is there no more
}

TEST(RunProgram, AProgramThatIsNotThereIsSaidToBeMissing) {
  EXPECT_EQ(run_program({"no-such-program-of-ours"}, "."), kProgramNotFound);
}

}  // namespace
}  // namespace sightline
