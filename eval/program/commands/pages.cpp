// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "eval/output/output_folder.h"
#include "eval/program/command_pages.h"
#include "eval/program/commands/commands.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

struct ManualArguments {
  std::string command;
  std::string folder;
};

void write_manual_pages(const std::vector<CommandPage>& pages, const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  write_file(folder / "sightline.1", manual_page(pages));
  for (const CommandPage& page : pages) {
    write_file(folder / fmt::format("sightline-{}.1", page.name), manual_page(page));
  }
}

void print_manual(const CLI::App& app, const ManualArguments& arguments) {
  const std::vector<CommandPage> pages = command_pages(app);
  if (!arguments.folder.empty()) return write_manual_pages(pages, arguments.folder);
  if (arguments.command.empty()) {
    std::cout << manual_page(pages);
    return;
  }
  std::vector<std::string> names;
  for (const CommandPage& page : pages) {
    names.push_back(page.name);
    if (page.name != arguments.command) continue;
    std::cout << manual_page(page);
    return;
  }
  throw InputError(fmt::format("manual: '{}' is no command{}", arguments.command,
                               suggestion(arguments.command, names)));
}

void print_completions(const CLI::App& app, const std::string& shell) {
  const std::vector<CommandPage> pages = command_pages(app);
  if (shell == "bash") std::cout << bash_completions(pages);
  if (shell == "zsh") std::cout << zsh_completions(pages);
  if (shell == "fish") std::cout << fish_completions(pages);
}

}  // namespace

void add_manual(CLI::App& app) {
  auto arguments = std::make_shared<ManualArguments>();
  CLI::App* sub = app.add_subcommand("manual", "The manual page of a command, for man");
  auto* command = sub->add_option("command", arguments->command, "Its name [the program's page]");
  sub->add_option("--into", arguments->folder, "Write the pages of all commands into a folder")
      ->excludes(command);
  sub->callback([&app, arguments] { print_manual(app, *arguments); });
}

void add_completions(CLI::App& app) {
  auto shell = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand(
      "completions", "What a shell sources to complete the program's commands and options");
  sub->add_option("shell", *shell, "Of which shell")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  sub->callback([&app, shell] { print_completions(app, *shell); });
}

}  // namespace sightline
