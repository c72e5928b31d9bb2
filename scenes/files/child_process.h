// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

namespace sightline {

/// A process that this one has forked, and the end of the pipe from which its words are read.
struct ChildProcess {
  pid_t process = -1;
  int pipe = -1;
};

/// How a process has ended: by a signal, or with an exit code.
struct ProcessEnd {
  int signal = 0;  ///< 0: by no signal
  int exit_code = 0;

  bool is_good() const { return signal == 0 && exit_code == 0; }
};

/// Forks this process. The child, which the system ends with this one however that ends, calls
/// `work` with the pipe's end to write on, and exits at once with the code that it returns, without
/// running destructors. `work` must let no exception out.
/// The caller reads and closes `pipe` and waits for `process`. Throws std::runtime_error where the
/// system has no pipe or no process to give.
ChildProcess fork_child(const std::function<int(int pipe)>& work);

/// Writes all of it, or as much as there is a reader for.
void write_all(int file, std::string_view bytes);

/// Waits until a child of this process has ended.
ProcessEnd wait_for(pid_t process);

/// The exit code of a program that is not there.
inline constexpr int kProgramNotFound = 127;

/// Runs a program (its name, then its arguments; looked for in PATH) within a folder, without
/// showing what it prints. Returns its exit code, -1 where a signal ended it, kProgramNotFound
/// where it cannot be started. The system ends it with this process, and what is thrown in the
/// pauses of the wait (pauses.h) ends it too.
int run_program(std::vector<std::string> arguments, const std::filesystem::path& folder);

}  // namespace sightline
