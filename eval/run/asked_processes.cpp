// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/asked_processes.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLogs = "logs";

// Each once: set-ups share their extractors.
std::vector<std::shared_ptr<ExternalProcess>> processes_of(const Study& study) {
  std::vector<std::shared_ptr<ExternalProcess>> processes;
  const auto add = [&processes](const std::shared_ptr<ExternalProcess>& process) {
    const bool is_new = std::find(processes.begin(), processes.end(), process) == processes.end();
    if (process && is_new) processes.push_back(process);
  };
  for (const TrialSolver& solver : study.solvers()) add(solver.process);
  if (study.images() != nullptr) {
    for (const ImageSetup& setup : study.images()->setups) {
      if (setup.guest) add(setup.guest->process);
    }
  }
  return processes;
}

}  // namespace

AskedProcesses::AskedProcesses(const Study& study, const fs::path& run_folder)
    : processes_(processes_of(study)) {
  if (processes_.empty()) return;
  for (const auto& process : processes_) process->require_program();
  places_.logs = run_folder / kLogs;
  std::error_code error;
  fs::create_directories(places_.logs, error);
  if (error) {
    throw InputError(fmt::format("{}: cannot be made: {}", places_.logs.string(), error.message()));
  }
  places_.scratch = scratch_.emplace().path();
}

AskedProcesses::Session AskedProcesses::begin(int job) const {
  ProcessPlaces places = places_;
  places.job = job;
  for (const auto& process : processes_) process->begin(places);
  return Session(processes_);
}

AskedProcesses::Session::~Session() {
  for (const auto& process : processes_) process->end();
}

}  // namespace sightline
