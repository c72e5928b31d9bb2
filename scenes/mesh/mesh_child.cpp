// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <new>

#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "scenes/files/child_process.h"
#include "scenes/files/input_error.h"
#include "scenes/mesh/mesh_soup.h"

namespace sightline {
namespace {

using Reader = std::function<MeshSoup(const std::filesystem::path&)>;

// The child's message: one of these, then an encoded soup or a line of text.
constexpr char kSoup = 'S';
constexpr char kInputError = 'I';
constexpr char kNoMemory = 'M';
constexpr size_t kMaxErrorBytes = 2000;
constexpr int kPipeBytes = 1 << 20;

// Sets the limit that a signal or an error answers, and leaves the one that kills as it was.
void limit(int resource, rlim_t value) {
  rlimit wanted{};
  if (getrlimit(resource, &wanted) != 0) return;
  wanted.rlim_cur = std::min(value, wanted.rlim_max);
  setrlimit(resource, &wanted);
}

// What the process has mapped already: limits are relative to it, because a graphics library maps
// much, and a sanitizer many terabytes.
uint64_t mapped_bytes() {
  uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

void confine(const ReaderLimits& limits) {
  for (const int number :
       {SIGINT, SIGTERM, SIGPIPE, SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGXCPU}) {
    signal(number, SIG_DFL);
  }
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_FSIZE, 0);
  limit(RLIMIT_CPU, static_cast<rlim_t>(limits.cpu_s));
  limit(RLIMIT_AS, mapped_bytes() + limits.memory_bytes);
}

// Reads, and writes one message. What crosses is written as it is encoded: a large mesh is in
// memory once, not twice.
void send_message(int pipe, const std::filesystem::path& file, const Reader& reader) {
  const auto fails = [&](char kind, const std::string& text) { write_all(pipe, kind + text); };
  try {
    const MeshSoup soup = reader(file);
    malloc_trim(0);  // what the reader's library had, the listener needs now
    write_all(pipe, {&kSoup, 1});
    encode(soup, [pipe](std::string_view piece) { write_all(pipe, piece); });
  } catch (const InputError& error) {
    fails(kInputError, error.what());
  } catch (const std::bad_alloc&) {
    fails(kNoMemory, "");
  } catch (const std::length_error&) {  // a count no vector can have
    fails(kNoMemory, "");
  } catch (const std::exception& error) {
    fails(kInputError,
          fmt::format("{}: cannot be read as a mesh: {}", file.string(), error.what()));
  }
}

// What the child does; its exit code.
int read_in_confinement(int pipe, const std::filesystem::path& file, const Reader& reader,
                        const ReaderLimits& limits) {
  // Libraries may print: their last words are not ours.
  constexpr int kPipe = STDERR_FILENO + 1;
  const int nowhere = open("/dev/null", O_RDWR);
  if (pipe != kPipe) dup2(pipe, kPipe);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, standard);
  close_range(kPipe + 1, ~0U, 0);
  confine(limits);
  send_message(kPipe, file, reader);
  return 0;
}

// The processor time that a process has used.
double work_s(pid_t process) {
  clockid_t clock{};
  timespec used{};
  if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &used) != 0) return 0;
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

// The child's pipe, until it closes it or has been waited for too long.
class Listener {
 public:
  Listener(const ChildProcess& child, const ReaderLimits& limits)
      : child_(child), limits_(limits) {}

  size_t next(char* to, size_t most) {
    // Waits are added up, none longer than twice what is asked for: the clock goes on while both
    // processes are stopped.
    constexpr int kWaitMs = 100;
    while (true) {
      const double worked_s = std::min<double>(work_s(child_.process), limits_.cpu_s);
      is_late_ = waited_s_ >= limits_.wait_s + kWaitPerWork * worked_s;
      if (is_late_) return 0;
      pollfd waiting{.fd = child_.pipe, .events = POLLIN, .revents = 0};
      const auto before = std::chrono::steady_clock::now();
      const int ready = poll(&waiting, 1, kWaitMs);
      const std::chrono::duration<double> turn = std::chrono::steady_clock::now() - before;
      waited_s_ += std::min(turn.count(), 2e-3 * kWaitMs);
      if (ready <= 0) continue;
      const ssize_t size = read(child_.pipe, to, most);
      if (size < 0 && errno == EINTR) continue;
      return size <= 0 ? 0 : static_cast<size_t>(size);
    }
  }

  bool is_late() const { return is_late_; }
  double waited_s() const { return waited_s_; }

 private:
  const ChildProcess& child_;
  const ReaderLimits& limits_;
  double waited_s_ = 0;
  bool is_late_ = false;
};

struct Outcome {
  char kind = 0;      // of the message; 0: there was none
  std::string error;  // the child's words, or what is wrong with its soup
  MeshSoup soup;
  ProcessEnd end;
  bool is_late = false;  // we ended it
  double waited_s = 0;
};

// Takes the child's message, then ends and reaps it.
Outcome listen(const ChildProcess& child, const std::filesystem::path& file,
               const ReaderLimits& limits) {
  Outcome outcome;
  Listener listener(child, limits);
  const ByteSource source = [&](char* to, size_t most) { return listener.next(to, most); };
  if (source(&outcome.kind, 1) == 1 && outcome.kind == kSoup) {
    try {
      outcome.soup = decode(source, file);
    } catch (const InputError& error) {
      outcome.error = error.what();
    }
  } else if (outcome.kind == kInputError) {
    outcome.error.resize(kMaxErrorBytes);
    size_t size = 0;
    while (const size_t more = source(outcome.error.data() + size, kMaxErrorBytes - size)) {
      size += more;
    }
    outcome.error.resize(size);
  }
  close(child.pipe);
  outcome.is_late = listener.is_late();
  outcome.waited_s = listener.waited_s();
  if (outcome.is_late) kill(child.process, SIGKILL);
  outcome.end = wait_for(child.process);
  return outcome;
}

// Why the child's message cannot be used; empty when it can.
std::string why_unusable(const Outcome& outcome, const ReaderLimits& limits) {
  const int signal = outcome.end.signal;
  if (outcome.is_late) {
    return fmt::format("its reader has been waited for {:.0f} s", outcome.waited_s);
  }
  if (signal == SIGXCPU) {
    return fmt::format("broken, or too large: reading it takes more than {} s of processor time",
                       limits.cpu_s);
  }
  if (signal == SIGPIPE) return "";  // we had heard enough
  if (signal == SIGKILL) return "its reader was killed, perhaps for want of memory";
  if (signal != 0) {
    return fmt::format("broken: its reader crashed on it ({})", strsignal(signal));
  }
  if (outcome.end.exit_code != 0) return "broken: its reader crashed on it";
  if (outcome.kind == 0) return "its reader ended without a word";
  if (outcome.kind == kNoMemory) {
    return fmt::format("broken, or too large: reading it takes more than {} MiB",
                       limits.memory_bytes >> 20);
  }
  return "";
}

std::string one_line(std::string text) {
  text.resize(std::min(text.size(), kMaxErrorBytes));
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return text;
}

}  // namespace

ReaderLimits limits_for(uint64_t file_bytes) {
  const ReaderLimits most;
  const uint64_t mebibytes = file_bytes >> 20;
  const uint64_t memory_bytes = (uint64_t{512} << 20) + 64 * file_bytes;
  const int cpu_s = static_cast<int>(std::min<uint64_t>(2 + mebibytes, most.cpu_s));
  return {.memory_bytes = std::min(memory_bytes, most.memory_bytes),
          .cpu_s = cpu_s,
          .wait_s = 60 + 2 * cpu_s};
}

MeshSoup read_in_child(const std::filesystem::path& file, const Reader& reader,
                       const ReaderLimits& limits) {
  const ChildProcess child =
      fork_child([&](int pipe) { return read_in_confinement(pipe, file, reader, limits); });
  fcntl(child.pipe, F_SETPIPE_SZ, kPipeBytes);  // a wish: fewer switches between the two
  Outcome outcome = listen(child, file, limits);
  const std::string problem = why_unusable(outcome, limits);
  if (!problem.empty()) throw InputError(fmt::format("{}: {}", file.string(), problem));
  if (!outcome.error.empty()) throw InputError(one_line(outcome.error));
  return std::move(outcome.soup);
}

}  // namespace sightline
