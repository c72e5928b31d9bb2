// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A program that runs beside this one and is spoken to in lines of text.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

namespace sightline {

/// The words of a command, as a shell would part them: at blanks, but for those in '...' or "..."
/// or after a backslash. Nothing else means anything: no shell sees the command. Throws InputError
/// for a quote that is left open and for a command without words.
std::vector<std::string> words_of_command(const std::string& command);

/// Where a program is: as its path says, or in PATH where it is a mere name. Throws InputError
/// where there is none that may be run.
std::filesystem::path find_program(const std::string& name);

/// How an exchange with a program ended.
enum class Hearing {
  kAnswered,
  kTimedOut,
  kEnded,    ///< it ended, or closed its standard output
  kTooLong,  ///< its line is longer than kMostAnswerBytes
};

/// Far more than an answer needs; a program that never ends its line must not fill the memory.
inline constexpr size_t kMostAnswerBytes = size_t{16} << 20;

/// A running program. Its standard input and output are this object's, its standard error is
/// appended to a file. It has a process group of its own and ends, with all that it has started in
/// that group, when this object does or when this process ends, however that ends: a small process
/// between the two sees to it. Only for one thread.
class ChildProgram {
 public:
  using Clock = std::chrono::steady_clock;

  /// Starts words[0], found by find_program. Throws InputError where it cannot be started, and
  /// std::runtime_error where the system has no pipe or no process to give.
  ChildProgram(const std::vector<std::string>& words, const std::filesystem::path& log);
  ~ChildProgram();
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  /// Writes a line and waits for one line, without its end, in `answer`. It neither waits beyond
  /// the deadline, though the program read nothing, nor is this process ended by a program that is
  /// gone. Throws Interrupted when this process is asked to end.
  Hearing ask(const std::string& line, Clock::time_point deadline, std::string& answer);

  /// Closes the program's input, which asks it to end, and gives it a moment to do so.
  void let_end();

 private:
  bool take_line(std::string& line);
  void send_some(std::string_view& rest);
  bool read_some();

  pid_t keeper_ = -1;
  int input_ = -1;
  int output_ = -1;
  std::string heard_;    // and not yet taken
  size_t searched_ = 0;  // of it, without finding the end of a line
};

}  // namespace sightline
