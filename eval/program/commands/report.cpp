// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "eval/program/commands/commands.h"
#include "eval/program/run_command.h"
#include "eval/run/run.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

}  // namespace

void add_report(CLI::App& app) {
  auto folder = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand(
      "report", "Write a run's results.csv, summary.json and report.html anew from its trials");
  sub->add_option("folder", *folder, "Folder of a run")->required();
  sub->callback([folder] {
    print_note(rewrite_report(*folder));
    std::cout << "report: " << (fs::path(*folder) / "report.html").string() << "\n";
  });
}

}  // namespace sightline
