// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The program `sightline`: reads the command line and calls what does the work.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
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

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

// The command that the line names; null where it names none.
const CLI::App* command_in(const CLI::App& app) {
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->parsed()) return command;
  }
  return nullptr;
}

// What is wrong with a command line: of a misspelt command or option also what was perhaps meant.
std::string mistake_in(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
  const CLI::App* const used = command_in(app);
  if (used == nullptr) {
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
    return fmt::format("'{}' is no command{}", argv[1], sightline::suggestion(argv[1], names));
  }
  const std::vector<std::string> options = option_names(*used);
  for (int i = 2; i < argc; ++i) {
    const std::string_view word = argv[i];
    const std::string option(word.substr(0, word.find('=')));
    const bool is_known = std::find(options.begin(), options.end(), option) != options.end();
    if (word == "--") break;
    if (!word.starts_with("--") || is_known) continue;
    return fmt::format("{} has no option {}{}", used->get_name(), option,
                       sightline::suggestion(option, options));
  }
  return fmt::format("{}: {}", used->get_name(), error.what());
}

// One line for it, and one that leads on. Help and the version, which are asked for, are as CLI11
// prints them.
int tell_usage(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
  if (error.get_exit_code() == 0) return app.exit(error);
  const CLI::App* const used = command_in(app);
  std::cerr << "sightline: " << sightline::in_one_line(mistake_in(app, error, argc, argv)) << "\n"
            << (used == nullptr
                    ? "sightline --help lists the commands\n"
                    : fmt::format("sightline {} --help lists its options\n", used->get_name()));
  return kUsageExit;
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
    return tell_usage(app, error, argc, argv);
  } catch (const sightline::Interrupted& interrupted) {
    std::cerr << "\nsightline: " << sightline::in_one_line(interrupted.what()) << '\n';
    return kInterruptedExit;
  } catch (const std::bad_alloc&) {
    std::cerr << "sightline: out of memory\n";
    return kInputErrorExit;
  } catch (const std::filesystem::filesystem_error& error) {  // such as links in a circle
    const std::string reason = error.path1().string() + ": " + error.code().message();
    std::cerr << "sightline: " << sightline::in_one_line(reason) << '\n';
    return kInputErrorExit;
  } catch (const std::exception& error) {
    std::cerr << "sightline: " << sightline::in_one_line(error.what()) << '\n';
    return kInputErrorExit;
  }
}
