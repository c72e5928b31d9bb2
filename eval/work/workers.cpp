// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/work/workers.h"

#include <algorithm>
#include <cerrno>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include "eval/work/interrupt.h"
#include "scenes/files/child_process.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

// A worker writes one kTick a step; if it fails, one kInputError or kFailure and then its text.
constexpr char kTick = '.';
constexpr char kInputError = 'I';
constexpr char kFailure = 'F';

struct Worker {
  pid_t process = -1;  // -1 once it has been waited for
  int pipe = -1;       // -1 once closed
  char failure = 0;
  std::string failure_text;
};

// What a worker does; its exit code.
int work_of(int index, int pipe, const std::function<void(int, const Tick&)>& work) {
  try {
    work(index, [pipe] { write_all(pipe, {&kTick, 1}); });
    return 0;
  } catch (const InputError& error) {
    write_all(pipe, kInputError + std::string(error.what()));
  } catch (const std::exception& error) {
    write_all(pipe, kFailure + std::string(error.what()));
  }
  return 1;
}

Worker start(int index, const std::vector<Worker>& earlier,
             const std::function<void(int, const Tick&)>& work) {
  const ChildProcess child = fork_child([&](int pipe) {
    for (const Worker& other : earlier) {
      if (other.pipe >= 0) close(other.pipe);
    }
    return work_of(index, pipe, work);
  });
  return {.process = child.process, .pipe = child.pipe, .failure = 0, .failure_text = ""};
}

// Waits for a worker that has closed its pipe; a crash, which says nothing, is a failure too.
void reap(Worker& worker) {
  const ProcessEnd end = wait_for(worker.process);
  worker.process = -1;
  if (worker.failure != 0 || end.is_good()) return;
  worker.failure = kFailure;
  worker.failure_text = end.signal != 0
                            ? fmt::format("a worker process was ended by signal {}", end.signal)
                            : "a worker process failed without a word";
}

// Takes what a worker has written; returns the steps it has done since.
int64_t take(Worker& worker) {
  char buffer[4096];
  const ssize_t size = read(worker.pipe, buffer, sizeof buffer);
  if (size < 0 && errno == EINTR) return 0;
  if (size <= 0) {
    close(worker.pipe);
    worker.pipe = -1;
    reap(worker);
    return 0;
  }
  int64_t ticks = 0;
  for (const char c : std::string_view(buffer, static_cast<size_t>(size))) {
    if (worker.failure != 0) {
      worker.failure_text += c;
    } else if (c == kTick) {
      ++ticks;
    } else {
      worker.failure = c;
    }
  }
  return ticks;
}

void listen(std::vector<Worker>& workers, const std::function<void(int64_t)>& on_ticks) {
  while (true) {
    std::vector<pollfd> waiting;
    std::vector<Worker*> who;
    for (Worker& worker : workers) {
      if (worker.pipe < 0) continue;
      waiting.push_back({.fd = worker.pipe, .events = POLLIN, .revents = 0});
      who.push_back(&worker);
    }
    if (waiting.empty()) return;
    poll(waiting.data(), waiting.size(), /*milliseconds=*/200);
    stop_if_interrupted();
    for (size_t i = 0; i < waiting.size(); ++i) {
      if (waiting[i].revents == 0) continue;
      on_ticks(take(*who[i]));
      if (who[i]->failure != 0) return;  // no use in letting the others finish
    }
  }
}

// Reads a failing worker's text to its end.
void drain(Worker& worker) {
  while (worker.pipe >= 0) take(worker);
}

void end_all(std::vector<Worker>& workers) {
  for (const Worker& worker : workers) {
    if (worker.process > 0) kill(worker.process, SIGKILL);
  }
  for (const Worker& worker : workers) {
    if (worker.process > 0) wait_for(worker.process);
    if (worker.pipe >= 0) close(worker.pipe);
  }
}

[[noreturn]] void throw_failure(const Worker& worker) {
  stop_if_interrupted();  // a signal to the whole group reaches workers first
  if (worker.failure == kInputError) throw InputError(worker.failure_text);
  throw std::runtime_error(worker.failure_text);
}

}  // namespace

void run_in_processes(int count, const std::function<void(int, const Tick&)>& work,
                      const std::function<void(int64_t)>& on_ticks) {
  std::vector<Worker> workers;
  try {
    for (int i = 0; i < count; ++i) workers.push_back(start(i, workers, work));
    listen(workers, on_ticks);
  } catch (...) {
    end_all(workers);
    throw;
  }
  const auto failed = std::find_if(workers.begin(), workers.end(),
                                   [](const Worker& worker) { return worker.failure != 0; });
  if (failed != workers.end()) {
    drain(*failed);
    const Worker failure = *failed;
    end_all(workers);
    throw_failure(failure);
  }
}

}  // namespace sightline
