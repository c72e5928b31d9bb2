// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/doors/external_process.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/doors/child_program.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// What a process may say of itself in place of an answer.
constexpr std::array kOwnStatuses = {EstimateOutcome::kNoEstimate,   EstimateOutcome::kRaisedError,
                                     EstimateOutcome::kTooFewPoints, EstimateOutcome::kDegenerate,
                                     EstimateOutcome::kBehindCamera, EstimateOutcome::kDiverged};

constexpr size_t kMostQuotedBytes = 200;
constexpr size_t kMostReasonBytes = 600;

ChildProgram::Clock::time_point after_s(double seconds) {
  return ChildProgram::Clock::now() + std::chrono::duration_cast<ChildProgram::Clock::duration>(
                                          std::chrono::duration<double>(seconds));
}

// What somebody's process wrote as a part of one line of ours.
std::string plain(const std::string& given, size_t most_bytes) {
  std::string text = given.substr(0, most_bytes);
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
  }
  return given.size() > most_bytes ? text + "..." : text;
}

std::string excerpt_of(const std::string& line) {
  return fmt::format("'{}'", plain(line, kMostQuotedBytes));
}

// The last words of a log, which say why a process ended.
std::string last_line_of(const fs::path& log) {
  std::ifstream stream(log);
  std::string last;
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty()) last = line;
  }
  return plain(last, kMostReasonBytes);
}

std::string text_of(Hearing hearing, double timeout_s) {
  switch (hearing) {
    case Hearing::kAnswered:
      return "answered";
    case Hearing::kTimedOut:
      return fmt::format("did not answer within {:g} s", timeout_s);
    case Hearing::kEnded:
      return "ended before it answered";
    case Hearing::kTooLong:
      return fmt::format("answered with more than {} bytes", kMostAnswerBytes);
  }
  return "";
}

EstimateOutcome outcome_of(Hearing hearing) {
  if (hearing == Hearing::kTimedOut) return EstimateOutcome::kTimedOut;
  return hearing == Hearing::kEnded ? EstimateOutcome::kCrashed : EstimateOutcome::kGarbled;
}

// Whether a process that failed so may be asked the next question.
bool is_still_good(EstimateOutcome outcome) {
  return outcome != EstimateOutcome::kTimedOut && outcome != EstimateOutcome::kCrashed &&
         outcome != EstimateOutcome::kGarbled;
}

// The status that an answer states; kOk where it states none.
EstimateOutcome status_in(const Json& answer, std::string& reason) {
  const std::string status = answer.value("status", "ok");
  if (status == "ok") return EstimateOutcome::kOk;
  if (answer.contains("reason")) reason = answer["reason"].get<std::string>();
  std::vector<std::string_view> known = {"ok"};
  for (const EstimateOutcome own : kOwnStatuses) {
    if (to_string(own) == status) return own;
    known.push_back(to_string(own));
  }
  throw BadAnswer(fmt::format("has the status {}, must be one of {}", excerpt_of(status),
                              fmt::join(known, ", ")));
}

}  // namespace

std::vector<Key> keys_of(ProcessSource& source) {
  const std::string table = "external.solver";
  return {
      {.table = table,
       .name = "name",
       .value = &source.name,
       .allowed = {},
       .unit = "",
       .meaning = "of the solver that the process is",
       .is_required = true},
      {.table = table,
       .name = "command",
       .value = &source.command,
       .allowed = {},
       .unit = "",
       .meaning = "a program and its arguments, parted at blanks outside of quotes; it speaks the "
                  "protocol of docs/external.md",
       .is_required = true},
      {.table = table,
       .name = "timeout_s",
       .value = &source.timeout_s,
       .allowed = {1e-3, 1e6},
       .unit = "s",
       .meaning = "without an answer for so long the trial has failed"},
      {.table = table,
       .name = "start_timeout_s",
       .value = &source.start_timeout_s,
       .allowed = {1e-3, 1e6},
       .unit = "s",
       .meaning = "so long may a process that was started take to say hello"},
  };
}

ExternalProcess::ExternalProcess(ProcessSource source, std::string role)
    : source_(std::move(source)),
      role_(std::move(role)),
      words_(words_of_command(source_.command)) {}

ExternalProcess::~ExternalProcess() = default;

void ExternalProcess::fail(const std::string& reason) const {
  throw InputError(
      fmt::format("external.{} {} ({}): {}", role_, source_.name, source_.command, reason));
}

void ExternalProcess::require_program() const {
  try {
    find_program(words_.front());
  } catch (const InputError& error) {
    fail(error.what());
  }
}

void ExternalProcess::begin(const ProcessPlaces& places) {
  places_ = places;
  is_begun_ = true;
}

void ExternalProcess::end() {
  if (program_) program_->let_end();
  program_.reset();
  is_begun_ = false;
}

fs::path ExternalProcess::log_file() const {
  const std::string job = places_.job > 0 ? fmt::format("-{}", places_.job) : "";
  return places_.logs / fmt::format("{}-{}{}.log", role_, source_.name, job);
}

void ExternalProcess::log(const std::string& text) const {
  std::ofstream(log_file(), std::ios::app) << "sightline: " << text << "\n";
}

void ExternalProcess::require_hello(const std::string& line) const {
  try {
    const Json hello = parse_json(line, "hello");
    if (hello.is_object() && hello.contains("protocol") && hello["protocol"] == kProcessProtocol) {
      return;
    }
  } catch (const InputError&) {
    // Said below.
  }
  throw BadAnswer(fmt::format("says hello with {}, must be {{\"protocol\": {}}}", excerpt_of(line),
                              kProcessProtocol));
}

EstimateOutcome ExternalProcess::start(std::string& reason) {
  try {
    program_ = std::make_unique<ChildProgram>(words_, log_file());
  } catch (const InputError& error) {
    fail(error.what());
  }
  const Json hello = {
      {"type", "hello"}, {"protocol", kProcessProtocol}, {"role", role_}, {"name", source_.name}};
  std::string line;
  const Hearing hearing = program_->ask(hello.dump(), after_s(source_.start_timeout_s), line);
  if (hearing == Hearing::kAnswered) {
    require_hello(line);
    has_said_hello_ = true;
    return EstimateOutcome::kOk;
  }
  reason = fmt::format("when asked for its hello it {}", text_of(hearing, source_.start_timeout_s));
  return outcome_of(hearing);
}

EstimateOutcome ExternalProcess::answer_to(
    Json question, const std::function<EstimateOutcome(const Json& answer)>& read,
    std::string& reason) {
  if (!program_) {
    const EstimateOutcome started = start(reason);
    if (started != EstimateOutcome::kOk) return started;
  }
  const int64_t id = questions_++;
  question["id"] = id;
  std::string line;
  const Hearing hearing = program_->ask(question.dump(), after_s(source_.timeout_s), line);
  if (hearing != Hearing::kAnswered) {
    reason = fmt::format("it {}", text_of(hearing, source_.timeout_s));
    return outcome_of(hearing);
  }
  try {
    const Json answer = parse_json(line, "the line");
    if (answer.at("id") != id) throw BadAnswer(fmt::format("has not the id {}", id));
    const EstimateOutcome status = status_in(answer, reason);
    return status == EstimateOutcome::kOk ? read(answer) : status;
  } catch (const Json::exception& error) {
    throw BadAnswer(fmt::format("{}: {}", words_of(error), excerpt_of(line)));
  } catch (const InputError& error) {
    throw BadAnswer(fmt::format("is {}: {}", excerpt_of(line), error.what()));
  } catch (const BadAnswer& error) {
    throw BadAnswer(fmt::format("{}: {}", error.what(), excerpt_of(line)));
  }
}

EstimateOutcome ExternalProcess::ask(
    Json question, int64_t trial, const std::function<EstimateOutcome(const Json& answer)>& read) {
  if (!is_begun_) fail("is not started here: only a run asks it");
  EstimateOutcome outcome = EstimateOutcome::kGarbled;
  std::string reason;
  try {
    outcome = answer_to(std::move(question), read, reason);
  } catch (const BadAnswer& error) {
    reason = fmt::format("its answer {}", error.what());
  }
  reason = plain(reason, kMostReasonBytes);
  if (!is_still_good(outcome)) program_.reset();
  if (!has_said_hello_ && outcome != EstimateOutcome::kOk) {
    const std::string last = last_line_of(log_file());
    fail(reason + (last.empty() ? "" : "; its last words: " + last));
  }
  if (outcome != EstimateOutcome::kOk) {
    log(fmt::format("trial {}: {}{}{}", trial, to_string(outcome), reason.empty() ? "" : ": ",
                    reason));
  }
  return outcome;
}

}  // namespace sightline
