// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "eval/program/guest_options.h"
#include "eval/run/run.h"
#include "eval/study/study_file.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace sightline {

/// What the command line says of a run, whatever it runs.
struct RunArguments {
  StudyOverrides overrides;
  GuestArguments guests;
  std::string out;
  int jobs = 0;  ///< processes; 0: see add_run_options
  std::string shard;
  std::string gl = "none";
  bool is_resumed = false;
  bool is_quiet = false;
  bool is_json = false;
};

/// Adds the options of every command that runs trials, but for --out, which --resume needs.
void add_run_options(CLI::App& sub, CLI::Option* out, RunArguments& arguments);

/// The folder that was named, else results/NAME, or the first of results/NAME-2, -3, ... that is
/// free.
std::filesystem::path results_folder(const std::string& name, const RunArguments& arguments);

/// What the command line says over a study's file, the guests included.
StudyOverrides overrides_of(const RunArguments& arguments);

/// The same as options of a run of a study, whose folder and command are still to be said. Throws
/// InputError for a shard that is none.
RunOptions run_options(const Study& study, const RunArguments& arguments);

/// Runs the study into a folder and says what came of it. Returns the exit code.
int run_command(const Study& study, const RunArguments& arguments, const std::filesystem::path& out,
                const std::string& command);

/// What a user should know of a result that is whole but for its figures.
void print_note(const RunResult& result);

/// 0, or 4 where some trials could not be run, which is said.
int exit_code_of(const RunResult& result);

}  // namespace sightline
