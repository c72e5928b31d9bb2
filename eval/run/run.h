// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "eval/study/study.h"
#include "eval/summary/summary.h"
#include "eval/work/shard.h"
#include "renderer/renderer.h"

namespace sightline {

struct RunOptions {
  std::filesystem::path out;  ///< must not exist, or be an empty folder
  int jobs = 1;
  Shard shard;
  bool is_resumed = false;  ///< continue what an ended run into `out` left, if it left anything
  bool show_progress = true;
  RendererOptions renderer;
  std::string command;  ///< as typed, for the manifest
};

struct RunResult {
  Summary summary;
  int64_t trials = 0;
  int64_t resumed_trials = 0;  ///< of them, what was there when this run began
  int64_t failed_trials = 0;   ///< that could not be imaged at all
  std::string figures_note;    ///< one line where figures/ lacks its .svg; else empty
};

/// Runs a study and leaves its folder: study.toml, manifest.json, results.sqlite, results.csv,
/// summary.json, report.html, figures/, timings.csv where times are taken, and logs/
/// of processes that were asked. With jobs > 1 that
/// many processes do a share each. Everything is written beside `out` first and takes its name at
/// the end. Trials are stored in batches of about a second. On failure the finished batches stay
/// where there are any, for a run with `is_resumed` to continue, and nothing else; on an interrupt
/// they stay only where this run has `is_resumed`. A run that continues another ends with the same
/// results, byte by byte, as one that was never ended, whatever the jobs of both; one that finds
/// the work complete does nothing. Throws InputError when the folder cannot be written, holds a run
/// of another study, seed, version or shard, or finished trials of a run that is not continued.
RunResult run_study(const Study& study, const RunOptions& options);

/// What all trials of a study say, to plan a larger one: run as run_study does, but `out` is only
/// where they lie meanwhile, and nothing is left.
Summary run_pilot(const Study& study, const RunOptions& options);

/// Writes a run's results.csv, summary.json, timings.csv and report.html anew from its
/// results.sqlite.
RunResult rewrite_report(const std::filesystem::path& folder);

}  // namespace sightline
