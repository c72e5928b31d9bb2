// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenes/files/child_process.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "scenes/files/pauses.h"

namespace sightline {
namespace {

// A child whose parent was killed would go on for nobody, and hold what a new run needs.
void end_with_parent(pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);  // it was killed before
}

// In a child: a program in place of this one, without what it prints.
[[noreturn]] void become_program(pid_t parent, const std::vector<char*>& argv,
                                 const std::filesystem::path& folder) {
  end_with_parent(parent);
  const int nowhere = open("/dev/null", O_WRONLY);
  const bool is_silent =
      nowhere >= 0 && dup2(nowhere, STDOUT_FILENO) >= 0 && dup2(nowhere, STDERR_FILENO) >= 0;
  if (is_silent && chdir(folder.c_str()) == 0) execvp(argv[0], argv.data());
  _exit(kProgramNotFound);
}

// Waits for a child, and kills it where a pause throws.
ProcessEnd wait_with_pauses(pid_t child) {
  constexpr timespec kBetween{.tv_sec = 0, .tv_nsec = 5'000'000};
  siginfo_t ended{};
  while (waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         ended.si_pid == 0) {
    try {
      take_pause();
    } catch (...) {
      kill(child, SIGKILL);
      wait_for(child);
      throw;
    }
    nanosleep(&kBetween, nullptr);
  }
  return wait_for(child);
}

}  // namespace

ChildProcess fork_child(const std::function<int(int pipe)>& work) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw std::runtime_error(fmt::format("pipe: {}", std::strerror(errno)));
  }
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) {
    const std::string reason = std::strerror(errno);
    for (const int end : ends) close(end);
    throw std::runtime_error(fmt::format("fork: {}", reason));
  }
  if (child == 0) {
    close(ends[0]);
    end_with_parent(parent);
    _exit(work(ends[1]));
  }
  close(ends[1]);
  return {.process = child, .pipe = ends[0]};
}

void write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;  // nobody reads any more
    bytes.remove_prefix(static_cast<size_t>(written));
  }
}

ProcessEnd wait_for(pid_t process) {
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) return {.signal = WTERMSIG(status), .exit_code = 0};
  return {.signal = 0, .exit_code = WEXITSTATUS(status)};
}

int run_program(std::vector<std::string> arguments, const std::filesystem::path& folder) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) return kProgramNotFound;
  if (child == 0) become_program(parent, argv, folder);
  const ProcessEnd end = wait_with_pauses(child);
  return end.signal == 0 ? end.exit_code : -1;
}

}  // namespace sightline
