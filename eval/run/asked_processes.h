// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "eval/doors/external_process.h"
#include "eval/study/study.h"
#include "eval/work/private_folder.h"

namespace sightline {

/// The processes that a run of a study may start: a study that is only read starts none. It has
/// room for their logs, logs/<role>-<name>.log of the run's folder (of job 1 and so on:
/// logs/<role>-<name>-1.log), and a private temporary folder, which goes with this. A study that
/// asks no processes has neither.
class AskedProcesses {
 public:
  /// Throws InputError where a process's program is not there or there is no place for a folder.
  AskedProcesses(const Study& study, const std::filesystem::path& run_folder);
  AskedProcesses(const AskedProcesses&) = delete;
  AskedProcesses& operator=(const AskedProcesses&) = delete;

  /// While this is there, questions start the processes; then they are ended.
  class Session {
   public:
    explicit Session(std::vector<std::shared_ptr<ExternalProcess>> processes)
        : processes_(std::move(processes)) {}
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

   private:
    std::vector<std::shared_ptr<ExternalProcess>> processes_;
  };

  /// To be kept by the one of the run's processes that does the trials.
  Session begin(int job) const;

 private:
  std::vector<std::shared_ptr<ExternalProcess>> processes_;
  ProcessPlaces places_;
  std::optional<PrivateFolder> scratch_;  ///< of a study that asks any
};

}  // namespace sightline
