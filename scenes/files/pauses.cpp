// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/files/pauses.h"

#include <atomic>

namespace sightline {
namespace {

std::atomic<void (*)()> what_to_call{nullptr};

}  // namespace

void call_in_pauses(void (*call)()) {
  what_to_call = call;
}

void take_pause() {
  if (void (*const call)() = what_to_call) call();
}

void pause_at_times() {
  constexpr unsigned kBetween = 256;  // a line takes a microsecond or more
  thread_local unsigned times = 0;
  if (++times % kBetween == 0) take_pause();
}

}  // namespace sightline
