// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How this library works inside a Python process, whose lock, signals and forks are Python's.
#pragma once

#include <chrono>

#include <pybind11/pybind11.h>

#include "eval/work/interrupt.h"

namespace sightline {

/// While it lives, this thread works without Python's lock: other threads of Python go on, Ctrl-C
/// ends the work (Interrupted), workers that are forked meanwhile may call Python, and OpenCV uses
/// one thread, as in the program (the user's own number of threads comes back afterwards).
class LongCall {
 public:
  LongCall();
  ~LongCall();
  LongCall(const LongCall&) = delete;
  LongCall& operator=(const LongCall&) = delete;

 private:
  bool has_signal();

  int opencv_threads_;
  std::chrono::steady_clock::time_point last_look_;
  InterruptWatch watch_;
  pybind11::gil_scoped_release release_;
};

/// While it lives, a long call's thread holds Python's lock again, to call what the user gave.
class CallToPython {
 public:
  CallToPython();
  ~CallToPython();
  CallToPython(const CallToPython&) = delete;
  CallToPython& operator=(const CallToPython&) = delete;

 private:
  pybind11::gil_scoped_acquire lock_;
  int long_calls_;
};

/// Lets forks know of Python. To be called once, when the module is loaded.
void prepare_forks();

}  // namespace sightline
