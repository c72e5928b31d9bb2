// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/workers.h"

#include <csignal>
#include <functional>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

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

}  // namespace
}  // namespace sightline
