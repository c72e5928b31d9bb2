// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/processors.h"

#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sightline {
namespace {

int by_quota(const std::string& cpu_max) {
  std::istringstream stream(cpu_max);
  return allowed_by_quota(stream);
}

TEST(Processors, AreThoseOfTheQuota) {
  EXPECT_EQ(by_quota("200000 100000\n"), 2);
  EXPECT_EQ(by_quota("150000 100000\n"), 2);
  EXPECT_EQ(by_quota("5000 100000\n"), 1);
  EXPECT_EQ(by_quota("max 100000\n"), 0);
  EXPECT_EQ(by_quota(""), 0);
  EXPECT_EQ(by_quota("1e99 1\n"), 10000);
}

TEST(Processors, AreThoseThatTheProcessMayUse) {
  EXPECT_GE(usable_processors(), 1);
  const pid_t child = fork();
  if (child == 0) {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(sched_getcpu(), &one);
    const bool is_set = sched_setaffinity(0, sizeof one, &one) == 0;
    _exit(is_set ? usable_processors() : 0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(WEXITSTATUS(status), 1);
}

}  // namespace
}  // namespace sightline
