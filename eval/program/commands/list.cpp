// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "eval/program/catalogue_lists.h"
#include "eval/program/commands/commands.h"
#include "eval/program/key_lists.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

struct ListArguments {
  std::string what;
  std::string table;
  bool is_markdown = false;
};

void print_list(const ListArguments& arguments) {
  if (arguments.what != "keys") {
    if (!arguments.table.empty() || arguments.is_markdown) {
      throw InputError("list: a table and --markdown belong to `sightline list keys`");
    }
    std::cout << catalogue_lists(arguments.what);
  } else if (arguments.is_markdown) {
    if (!arguments.table.empty()) throw InputError("list keys: --markdown is of all tables");
    std::cout << key_page();
  } else {
    std::cout << key_list(arguments.table);
  }
}

}  // namespace

void add_list(CLI::App& app) {
  auto arguments = std::make_shared<ListArguments>();
  CLI::App* sub = app.add_subcommand(
      "list", "List targets, extractors, solvers, methods and studies, or the keys of files");
  sub->add_option("what", arguments->what,
                  "targets, extractors, solvers, methods, studies, keys, columns (of results) or "
                  "measures (of compare); without: all but the last three. "
                  "Or the name of one entry, for all about it");
  sub->add_option("table", arguments->table, "Of keys: their table, for example image [all]");
  sub->add_flag("--markdown", arguments->is_markdown, "Of keys: as the page docs/keys.md");
  sub->callback([arguments] { print_list(*arguments); });
}

}  // namespace sightline
