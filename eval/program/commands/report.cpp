// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "eval/output/plain_text.h"
#include "eval/program/commands/commands.h"
#include "eval/program/run_command.h"
#include "eval/run/run.h"
#include "scenes/files/child_process.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

// The page in the browser that the desktop has for pages.
void open_page(const fs::path& page) {
  const int exit_code = run_program({"xdg-open", page.string()}, page.parent_path());
  if (exit_code == 0) return;
  throw InputError(fmt::format(
      "--open: {}", exit_code == kProgramNotFound
                        ? "there is no xdg-open (package xdg-utils); open the page by hand"
                        : fmt::format("xdg-open ended with {}", exit_code)));
}

struct ReportArguments {
  std::string folder;
  bool is_opened = false;
};

}  // namespace

void add_report(CLI::App& app) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* sub = app.add_subcommand(
      "report", "Write a run's results.csv, summary.json and report.html anew from its trials");
  sub->add_option("folder", arguments->folder, "Folder of a run")->required();
  sub->add_flag("--open", arguments->is_opened, "Show the page in the desktop's browser");
  sub->callback([arguments] {
    print_note(rewrite_report(arguments->folder));
    const fs::path page = fs::absolute(arguments->folder) / "report.html";
    std::cout << "report: " << plain_line(page.string()) << std::endl;
    if (arguments->is_opened) open_page(page);
  });
}

}  // namespace sightline
