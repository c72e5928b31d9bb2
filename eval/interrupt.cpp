// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/interrupt.h"

#include <csignal>

namespace sightline {
namespace {

// A signal handler can reach nothing but a global of this type.
volatile std::sig_atomic_t was_interrupted = 0;

void remember(int) {
  was_interrupted = 1;
}

}  // namespace

void remember_interrupts() {
  std::signal(SIGINT, remember);
  std::signal(SIGTERM, remember);
}

void stop_if_interrupted() {
  if (was_interrupted != 0) throw Interrupted();
}

}  // namespace sightline
