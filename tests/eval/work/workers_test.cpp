// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/workers.h"

#include <csignal>
#include <functional>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "eval/work/interrupt.h"
#include "scenes/files/child_process.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

using testing::HasSubstr;

constexpr unsigned kLongS = 600;  // a worker that nobody ends outlasts the test's own limit

std::string failure_of(const std::function<void(int, const Tick&)>& work) {
  try {
    run_in_processes(2, work, [](int64_t) {});
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST(Workers, CountTheirSteps) {
  int64_t steps = 0;
  run_in_processes(
      3,
      [](int index, const Tick& tick) {
        for (int i = 0; i <= index; ++i) tick();
      },
      [&steps](int64_t n) { steps += n; });
  EXPECT_EQ(steps, 1 + 2 + 3);
}

TEST(Workers, AnErrorEndsTheOthersAndKeepsItsText) {
  EXPECT_THAT(failure_of([](int index, const Tick&) {
                if (index == 0) sleep(kLongS);
                throw InputError("the mesh is broken");
              }),
              HasSubstr("the mesh is broken"));
  EXPECT_THROW(run_in_processes(
                   1, [](int, const Tick&) { throw InputError("bad"); }, [](int64_t) {}),
               InputError);
}

TEST(Workers, ACrashEndsTheOthersAndIsSaid) {
  EXPECT_THAT(failure_of([](int index, const Tick&) {
                if (index == 0) sleep(kLongS);
                raise(SIGKILL);
              }),
              HasSubstr("signal 9"));
}

// The exit code of a process that asks itself to end and then does this.
int exit_code_after_a_signal(const std::function<int()>& then) {
  const ChildProcess child = fork_child([&then](int) {
    close(STDERR_FILENO);  // its last words are not the test's
    open("/dev/null", O_WRONLY);
    remember_interrupts();
    raise(SIGTERM);
    return then();
  });
  close(child.pipe);
  return wait_for(child.process).exit_code;
}

TEST(Interrupts, EndAStepThatTakesLongAndNotWhatHasHeardThem) {
  constexpr int kInterrupted = 130, kOwn = 7;
  EXPECT_EQ(exit_code_after_a_signal([] {
              while (true) sleep(kLongS);
              return kOwn;
            }),
            kInterrupted);
  EXPECT_EQ(exit_code_after_a_signal([] {
              EXPECT_THROW(stop_if_interrupted(), Interrupted);
              const unsigned left_s = sleep(2);  // to end well takes longer than the long step
              return left_s == 0 ? kOwn : 1;
            }),
            kOwn);
}

TEST(InterruptWatch, SaysYesForGoodAndToItsOwnScopeAlone) {
  int asked = 0;
  {
    const InterruptWatch watch([&asked] { return ++asked == 2; });
    EXPECT_NO_THROW(stop_if_interrupted());
    EXPECT_THROW(stop_if_interrupted(), Interrupted);
    EXPECT_THROW(stop_if_interrupted(), Interrupted) << "a signal that has come does not go";
    EXPECT_EQ(asked, 2);
    const InterruptWatch inner([] { return false; });
    EXPECT_THROW(stop_if_interrupted(), Interrupted) << "the outer one still counts";
  }
  EXPECT_NO_THROW(stop_if_interrupted());
}

}  // namespace
}  // namespace sightline
