// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/merge.h"

#include <filesystem>
#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "eval/output/plain_text.h"
#include "eval/program/commands/commands.h"
#include "eval/program/run_command.h"
#include "eval/work/interrupt.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

}  // namespace

void add_merge(CLI::App& app, const std::string& command, int& exit_code) {
  auto shards = std::make_shared<std::vector<fs::path>>();
  auto out = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand("merge", "Join the folders of a study's shards into one");
  sub->add_option("shards", *shards, "Folders of all shards of one study")->required();
  sub->add_option("--out", *out, "Folder for the joined results")->required();
  sub->callback([shards, out, command, &exit_code] {
    remember_interrupts();
    const RunResult result = merge_runs(*shards, *out, command);
    std::cout << "report: " << plain_line((fs::path(*out) / "report.html").string()) << "\n";
    print_note(result);
    exit_code = exit_code_of(result);
  });
}

}  // namespace sightline
