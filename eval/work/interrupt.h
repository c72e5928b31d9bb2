// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <stdexcept>

namespace sightline {

/// The user pressed Ctrl-C or the system asked the program to end. The text says what became of the
/// work.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted; nothing was written") {}
  using std::runtime_error::runtime_error;
};

/// From here on the first signal that asks the process to end is remembered instead, so that long
/// work can stop between two steps, or in the middle of a file that is read, and leave nothing
/// half-written. Where a second passes without stop_if_interrupted(), in a long step, the process
/// ends at once with the exit code 130 and leaves what a killed one leaves. For the commands that
/// write.
void remember_interrupts();

/// As long as it lives, stop_if_interrupted() of this thread also asks `has_come`, until that says
/// yes: for whoever embeds this program and has signal handlers of its own.
class InterruptWatch {
 public:
  explicit InterruptWatch(std::function<bool()> has_come);
  ~InterruptWatch();
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;

  bool has_come();

 private:
  std::function<bool()> ask_;
  bool has_come_ = false;
  InterruptWatch* outer_;  // of the same thread
};

/// Throws Interrupted once a signal has come.
void stop_if_interrupted();

}  // namespace sightline
