// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/interrupt.h"

#include <csignal>

namespace sightline {
namespace {

// A signal handler can reach nothing but a global of this type.
volatile std::sig_atomic_t was_interrupted = 0;

void remember(int signal) {
  was_interrupted = 1;
  std::signal(signal, SIG_DFL);  // a second one ends the process at once
}

}  // namespace

void remember_interrupts() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    // Whoever started the program may have it outlive a hang-up (nohup) or a Ctrl-C (&).
    if (std::signal(signal, remember) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
  // A full disk or a closed pipe is a failed write, which is reported, not the end of the process.
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
}

void stop_if_interrupted() {
  if (was_interrupted != 0) throw Interrupted();
}

}  // namespace sightline
