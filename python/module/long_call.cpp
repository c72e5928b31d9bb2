// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "python/module/long_call.h"

#include <csignal>
#include <utility>

#include <opencv2/core/utility.hpp>
#include <pthread.h>

namespace sightline {
namespace {

namespace py = pybind11;

// How many long calls this thread is in, and not in a call back to Python from one. Forks of any
// other thread are Python's own business, which prepares them itself.
thread_local int long_calls = 0;
thread_local PyGILState_STATE lock_at_fork;

void before_fork() {
  if (long_calls == 0) return;
  lock_at_fork = PyGILState_Ensure();
  PyOS_BeforeFork();
}

void after_fork_in_parent() {
  if (long_calls == 0) return;
  PyOS_AfterFork_Parent();
  PyGILState_Release(lock_at_fork);
}

// A worker leaves Ctrl-C, which reaches all processes of a terminal, to the one that ends it.
void after_fork_in_child() {
  if (long_calls == 0) return;
  std::signal(SIGINT, SIG_IGN);
  PyOS_AfterFork_Child();
  PyGILState_Release(lock_at_fork);
}

}  // namespace

LongCall::LongCall()
    : opencv_threads_(cv::getNumThreads()), watch_([this] { return has_signal(); }) {
  cv::setNumThreads(1);
  ++long_calls;
}

LongCall::~LongCall() {
  --long_calls;
  cv::setNumThreads(opencv_threads_);
}

// Python's handlers only remember a signal; to look takes the lock, which others may hold for
// milliseconds.
bool LongCall::has_signal() {
  constexpr std::chrono::milliseconds kBetweenLooks{20};
  const auto now = std::chrono::steady_clock::now();
  if (now - last_look_ < kBetweenLooks) return false;
  last_look_ = now;
  const CallToPython call;
  if (PyErr_CheckSignals() == 0) return false;
  PyErr_Clear();
  return true;
}

CallToPython::CallToPython() : long_calls_(std::exchange(long_calls, 0)) {}

CallToPython::~CallToPython() {
  long_calls = long_calls_;
}

void prepare_forks() {
  pthread_atfork(before_fork, after_fork_in_parent, after_fork_in_child);
}

}  // namespace sightline
