// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The program `sightline`: reads the command line and calls what does the work.
#include <cstdlib>
#include <iostream>

#include <CLI/CLI.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>

#include "eval/output/plain_text.h"
#include "eval/output/terminal.h"
#include "eval/program/commands.h"
#include "eval/work/interrupt.h"
#include "eval/work/kept_memory.h"
#include "scenes/files/input_error.h"

namespace {

// What is said to whoever only types the program's name.
constexpr const char* kFirstWords =
    R"(Sightline renders meshed targets, estimates their pose, and measures every step against the truth.

  see it work        sightline demo
  run a study        sightline study boeing-table1     (sightline list studies)
  make images        sightline render cube --count 100 --out set
  judge your own     sightline score estimates.csv --dataset set    (or evaluate, see docs/doors.md)

sightline --help lists all commands, sightline COMMAND --help their options.
)";

constexpr int kInputErrorExit = 1;
constexpr int kUsageExit = 2;
constexpr int kInterruptedExit = 130;  // as shells say it

std::string command_line(int argc, char** argv) {
  std::string text = "sightline";
  for (int i = 1; i < argc; ++i) text += " " + sightline::shell_word(argv[i]);
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);  // processes are the unit of parallel work
  // What it cannot read we say in a line of our own.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  sightline::keep_freed_memory();
  if (const size_t columns = sightline::look_of_standard_output().columns; columns > 0) {
    sightline::set_text_width(columns);
  }
  CLI::App app(
      "Sightline renders meshed targets under known poses, extracts features from the images,\n"
      "estimates the pose from them, and measures every step against the truth.",
      "sightline");
  app.set_version_flag("--version", SIGHTLINE_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 good, 1 input error, 2 usage, 3 `compare` found a regression or `score` what "
      "is\n"
      "not as required, 4 some trials could not be run, 130 interrupted.\n"
      "Begin with:  sightline demo    sightline list");
  if (argc == 1) {
    std::cerr << kFirstWords;
    return kUsageExit;
  }
  app.failure_message([](const CLI::App*, const CLI::Error& error) {
    return sightline::in_one_line(error.what()) + "\nRun with --help for more information.\n";
  });
  int exit_code = 0;
  sightline::add_commands(app, command_line(argc, argv), exit_code);
  try {
    app.parse(argc, argv);
    std::cout.flush();
    if (!std::cout) throw sightline::InputError("standard output cannot be written");
    return exit_code;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageExit;
  } catch (const sightline::Interrupted& interrupted) {
    std::cerr << "\nsightline: " << sightline::in_one_line(interrupted.what()) << '\n';
    return kInterruptedExit;
  } catch (const std::bad_alloc&) {
    std::cerr << "sightline: out of memory\n";
    return kInputErrorExit;
  } catch (const std::exception& error) {
    std::cerr << "sightline: " << sightline::in_one_line(error.what()) << '\n';
    return kInputErrorExit;
  }
}
