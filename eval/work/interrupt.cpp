// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/interrupt.h"

#include <csignal>
#include <string_view>
#include <utility>

#include <sys/time.h>
#include <unistd.h>

#include "scenes/files/pauses.h"

namespace sightline {
namespace {

// A signal handler can reach nothing but a global of this type.
volatile std::sig_atomic_t was_interrupted = 0;

thread_local InterruptWatch* innermost_watch = nullptr;

// Who remembers signals. Its workers inherit the handlers, but are ended by it.
volatile pid_t listener = 0;

// A step took longer than anybody waits (an image of gigapixels): whatever is written is written so
// that a process may be killed at any moment.
void end_at_once(int) {
  constexpr std::string_view kWords =
      "\nsightline: interrupted in the middle of a long step; finished trials and images are kept "
      "for --resume\n";
  const ssize_t written = write(STDERR_FILENO, kWords.data(), kWords.size());
  _exit(written < 0 ? 1 : 130);
}

void remember(int signal) {
  // Less than the second that is promised: to give back gigabytes takes its time too.
  constexpr itimerval kLongestStep = {.it_interval = {},
                                      .it_value = {.tv_sec = 0, .tv_usec = 700'000}};
  was_interrupted = 1;
  if (getpid() == listener) setitimer(ITIMER_REAL, &kLongestStep, nullptr);
  std::signal(signal, SIG_DFL);  // a second one ends the process at once
}

}  // namespace

void remember_interrupts() {
  call_in_pauses(stop_if_interrupted);
  listener = getpid();
  std::signal(SIGALRM, end_at_once);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    // Whoever started the program may have it outlive a hang-up (nohup) or a Ctrl-C (&).
    if (std::signal(signal, remember) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
  // A full disk or a closed pipe is a failed write, which is reported, not the end of the process.
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
}

InterruptWatch::InterruptWatch(std::function<bool()> has_come)
    : ask_(std::move(has_come)), outer_(std::exchange(innermost_watch, this)) {}

InterruptWatch::~InterruptWatch() {
  innermost_watch = outer_;
}

bool InterruptWatch::has_come() {
  has_come_ = has_come_ || ask_() || (outer_ != nullptr && outer_->has_come());
  return has_come_;
}

void stop_if_interrupted() {
  if (was_interrupted != 0) {
    alarm(0);  // it is heard: the work ends by itself, and takes its time to do so well
    throw Interrupted();
  }
  if (innermost_watch != nullptr && innermost_watch->has_come()) throw Interrupted();
}

}  // namespace sightline
