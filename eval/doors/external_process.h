// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A process of somebody else's that answers the questions of a study's trials, in lines of JSON on
// its standard input and output. The protocol: docs/external.md.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "eval/output/json.h"
#include "eval/records/names.h"
#include "scenes/scene/keys.h"

namespace sightline {

class ChildProgram;

/// The version of the protocol that is spoken here.
inline constexpr int kProcessProtocol = 1;

/// What a study says of a process: a table of [[external.solver]].
struct ProcessSource {
  std::string name;     ///< of the solver or extractor
  std::string command;  ///< a program and its arguments
  double timeout_s = 10;
  double start_timeout_s = 60;
};

std::vector<Key> keys_of(ProcessSource& source);

/// Where a run that may start processes has room for them.
struct ProcessPlaces {
  std::filesystem::path logs;     ///< a folder for what they write to their standard error
  std::filesystem::path scratch;  ///< a folder, nobody else's, for images that they are to read
  int job = 0;                    ///< which of the run's processes starts them
};

/// What the process answers is none by the protocol; what() says why.
class BadAnswer : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The process of one solver or extractor. A study that is only read starts nothing: it must be
/// begun first, as a run does and a report does not. It is then started by the first question, and
/// anew by the first after a failure. Only for one thread.
class ExternalProcess {
 public:
  /// `role` is "solver" or "extractor". Throws InputError for a command without words.
  ExternalProcess(ProcessSource source, std::string role);
  ~ExternalProcess();

  const std::string& name() const { return source_.name; }
  const std::filesystem::path& scratch() const { return places_.scratch; }
  int job() const { return places_.job; }

  /// Throws InputError where there is no such program.
  void require_program() const;
  /// From here on it may be started.
  void begin(const ProcessPlaces& places);
  /// Asks it to end, and ends it where it does not; until the next begin() it is not started.
  void end();

  /// Asks a question, of the trial of that number, and gives the answer to `read`, which may throw
  /// BadAnswer. Returns what read returns or, of an answer that has a status of its own, that; or
  /// what went wrong. The reason goes to the log. Throws InputError where the process has not been
  /// begun, and where it never said hello: then it is the command that is wrong.
  EstimateOutcome ask(Json question, int64_t trial,
                      const std::function<EstimateOutcome(const Json& answer)>& read);

 private:
  EstimateOutcome answer_to(Json question,
                            const std::function<EstimateOutcome(const Json& answer)>& read,
                            std::string& reason);
  EstimateOutcome start(std::string& reason);
  void require_hello(const std::string& line) const;
  [[noreturn]] void fail(const std::string& reason) const;
  std::filesystem::path log_file() const;
  void log(const std::string& text) const;

  ProcessSource source_;
  std::string role_;
  std::vector<std::string> words_;
  ProcessPlaces places_;
  std::unique_ptr<ChildProgram> program_;  // null while it does not run
  bool is_begun_ = false;
  bool has_said_hello_ = false;  // ever
  int64_t questions_ = 0;
};

}  // namespace sightline
