// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/doors/child_program.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "eval/work/interrupt.h"
#include "scenes/files/child_process.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kInterruptCheck{100};
constexpr std::chrono::milliseconds kTimeToEnd{1000};

[[noreturn]] void fail_of_system(const char* what) {
  throw std::runtime_error(fmt::format("{}: {}", what, std::strerror(errno)));
}

// A file descriptor that is closed with its scope. None is below kFirst, so that the child's
// standard ones can be put in place without overwriting any.
class Descriptor {
 public:
  static constexpr int kFirst = 10;

  explicit Descriptor(int file) : file_(fcntl(file, F_DUPFD_CLOEXEC, kFirst)) {
    ::close(file);
    if (file_ < 0) fail_of_system("no file descriptor is left");
  }
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  Descriptor(Descriptor&& other) noexcept : file_(other.release()) {}

  int get() const { return file_; }
  int release() { return std::exchange(file_, -1); }
  void close() {
    if (file_ >= 0) ::close(release());
  }

 private:
  int file_;
};

// Two ends that are connected: the first is read, the second is written.
struct Ends {
  Descriptor read;
  Descriptor write;
};

Ends make_pipe() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) fail_of_system("pipe");
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

// To be written with MSG_NOSIGNAL, which a pipe cannot.
Ends make_socket() {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    fail_of_system("socketpair");
  }
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

Descriptor open_log(const fs::path& log) {
  const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (file < 0) {
    throw InputError(fmt::format("{}: cannot be written: {}", log.string(), std::strerror(errno)));
  }
  return Descriptor(file);
}

// All that a child needs, made before the fork: after it, memory must not be asked for.
struct Launch {
  const char* program;
  char* const* arguments;
  int input, output, log, failure;
};

// In the place of these the program's standard ones; nothing else of this process stays open.
constexpr unsigned kFailureFile = 3;

void place_files(const Launch& launch) {
  dup2(launch.input, STDIN_FILENO);
  dup2(launch.output, STDOUT_FILENO);
  dup2(launch.log, STDERR_FILENO);
  dup3(launch.failure, kFailureFile, O_CLOEXEC);
  close_range(kFailureFile + 1, ~0U, 0);
}

[[noreturn]] void become_program(const Launch& launch, pid_t keeper) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != keeper) _exit(1);
  for (const int signal : {SIGPIPE, SIGXFSZ, SIGCHLD}) std::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  execve(launch.program, launch.arguments, environ);
  const int error = errno;
  write_all(kFailureFile, {reinterpret_cast<const char*>(&error), sizeof error});
  _exit(kProgramNotFound);
}

// The process between: it waits until the program has ended, or until its owner asks it to end or
// is gone itself, and then ends the program's whole group. All signals are blocked here.
[[noreturn]] void keep_program(const Launch& launch, pid_t owner) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  prctl(PR_SET_CHILD_SUBREAPER, 1);  // whom the program leaves behind is waited for here
  if (getppid() != owner) _exit(1);
  std::signal(SIGCHLD, SIG_DFL);
  place_files(launch);
  const pid_t program = fork();
  if (program == 0) become_program(launch, getppid());
  if (program < 0) {
    const int error = errno;
    write_all(kFailureFile, {reinterpret_cast<const char*>(&error), sizeof error});
    _exit(1);
  }
  setpgid(program, program);  // as the program does, whichever of them comes first
  close_range(0, ~0U, 0);
  sigset_t awaited;
  sigemptyset(&awaited);
  sigaddset(&awaited, SIGCHLD);
  sigaddset(&awaited, SIGTERM);
  bool has_ended = false;
  while (!has_ended) {
    const int signal = sigwaitinfo(&awaited, nullptr);
    if (signal == SIGTERM) break;
    siginfo_t info{};
    // Left to be waited for, so that its number stays that of the group.
    has_ended =
        waitid(P_PID, static_cast<id_t>(program), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
        info.si_pid == program;
  }
  kill(-program, SIGKILL);
  while (waitpid(-program, nullptr, 0) > 0) {
  }
  _exit(0);
}

pid_t fork_keeper(const Launch& launch) {
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  // A handler of this process has nothing to do in the child.
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const pid_t owner = getpid();
  const pid_t keeper = fork();
  if (keeper == 0) keep_program(launch, owner);
  const int error = errno;
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  errno = error;
  if (keeper < 0) fail_of_system("fork");
  return keeper;
}

// The reason why the program was not started; 0 where it was.
int failure_in(int file) {
  int error = 0;
  ssize_t size = -1;
  do {
    size = read(file, &error, sizeof error);
  } while (size < 0 && errno == EINTR);
  return size == sizeof error ? error : 0;
}

void end_keeper(pid_t keeper) {
  kill(keeper, SIGTERM);
  wait_for(keeper);
}

}  // namespace

std::vector<std::string> words_of_command(const std::string& command) {
  std::vector<std::string> words;
  bool is_in_word = false;
  char quote = 0;
  for (size_t i = 0; i < command.size(); ++i) {
    const char c = command[i];
    const bool is_blank = c == ' ' || c == '\t' || c == '\n';
    if (quote == 0 && is_blank) {
      is_in_word = false;
      continue;
    }
    if (!is_in_word) words.emplace_back();
    is_in_word = true;
    if (c == '\\' && quote != '\'' && i + 1 < command.size()) {
      words.back() += command[++i];
    } else if (c == quote) {
      quote = 0;
    } else if (quote == 0 && (c == '\'' || c == '"')) {
      quote = c;
    } else {
      words.back() += c;
    }
  }
  if (quote != 0) {
    throw InputError(fmt::format("is \"{}\", must close its quote {}", command, quote));
  }
  if (words.empty() || words[0].empty()) {
    throw InputError("is empty, must be a program and its arguments");
  }
  return words;
}

fs::path find_program(const std::string& name) {
  const auto can_be_run = [](const fs::path& file) {
    std::error_code none;
    return fs::is_regular_file(file, none) && access(file.c_str(), X_OK) == 0;
  };
  if (name.find('/') != std::string::npos) {
    if (can_be_run(name)) return name;
    throw InputError(fmt::format("cannot be started: {} is no program that may be run", name));
  }
  const char* const given = std::getenv("PATH");
  std::string folders = given != nullptr ? given : "/usr/bin:/bin";
  for (size_t begin = 0; begin <= folders.size();) {
    const size_t end = std::min(folders.find(':', begin), folders.size());
    const fs::path folder = end > begin ? folders.substr(begin, end - begin) : ".";
    if (can_be_run(folder / name)) return folder / name;
    begin = end + 1;
  }
  throw InputError(fmt::format("cannot be started: there is no program '{}' in PATH", name));
}

ChildProgram::ChildProgram(const std::vector<std::string>& words, const fs::path& log) {
  const fs::path program = find_program(words.front());
  std::vector<std::string> texts = words;
  std::vector<char*> arguments;
  for (std::string& text : texts) arguments.push_back(text.data());
  arguments.push_back(nullptr);
  Ends input = make_socket();
  Ends output = make_pipe();
  Ends failure = make_pipe();
  const Descriptor log_file = open_log(log);
  keeper_ = fork_keeper({program.c_str(), arguments.data(), input.read.get(), output.write.get(),
                         log_file.get(), failure.write.get()});
  failure.write.close();
  if (const int error = failure_in(failure.read.get()); error != 0) {
    end_keeper(keeper_);
    throw InputError(
        fmt::format("cannot be started: {}: {}", program.string(), std::strerror(error)));
  }
  input_ = input.write.release();
  output_ = output.read.release();
  fcntl(output_, F_SETFL, O_NONBLOCK);
}

ChildProgram::~ChildProgram() {
  end_keeper(keeper_);
  if (input_ >= 0) close(input_);
  close(output_);
}

bool ChildProgram::take_line(std::string& line) {
  const size_t end = heard_.find('\n', searched_);
  searched_ = heard_.size();
  if (end == std::string::npos) return false;
  line = heard_.substr(0, end);
  heard_.erase(0, end + 1);
  searched_ = 0;
  return true;
}

// A program that no longer reads may still have answered.
void ChildProgram::send_some(std::string_view& rest) {
  const ssize_t sent = send(input_, rest.data(), rest.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  if (sent >= 0) {
    rest.remove_prefix(static_cast<size_t>(sent));
  } else if (errno != EAGAIN && errno != EINTR) {
    rest = {};
  }
}

// Whether there may be more to come.
bool ChildProgram::read_some() {
  std::array<char, 65536> buffer;
  const ssize_t size = read(output_, buffer.data(), buffer.size());
  if (size > 0) heard_.append(buffer.data(), static_cast<size_t>(size));
  return size > 0 || (size < 0 && (errno == EAGAIN || errno == EINTR));
}

Hearing ChildProgram::ask(const std::string& line, Clock::time_point deadline,
                          std::string& answer) {
  const std::string whole = line + "\n";
  std::string_view rest = whole;
  send_some(rest);
  while (!take_line(answer)) {
    if (heard_.size() > kMostAnswerBytes) return Hearing::kTooLong;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0) return Hearing::kTimedOut;
    std::array<pollfd, 2> files = {pollfd{.fd = output_, .events = POLLIN, .revents = 0},
                                   pollfd{.fd = input_, .events = POLLOUT, .revents = 0}};
    poll(files.data(), rest.empty() ? 1 : 2,
         static_cast<int>(std::min(left, kInterruptCheck).count()));
    stop_if_interrupted();
    if (files[1].revents != 0) send_some(rest);
    if (files[0].revents != 0 && !read_some()) return Hearing::kEnded;
  }
  return answer.size() > kMostAnswerBytes ? Hearing::kTooLong : Hearing::kAnswered;
}

void ChildProgram::let_end() {
  close(std::exchange(input_, -1));
  const Clock::time_point deadline = Clock::now() + kTimeToEnd;
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0) return;
    pollfd file{.fd = output_, .events = POLLIN, .revents = 0};
    const int ready = poll(&file, 1, static_cast<int>(left.count()));
    if (ready > 0 && !read_some()) return;
    heard_.clear();
    searched_ = 0;
  }
}

}  // namespace sightline
