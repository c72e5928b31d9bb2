// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "eval/output/terminal.h"
#include "eval/program/catalogue_lists.h"
#include "eval/program/commands/commands.h"
#include "eval/program/key_lists.h"
#include "eval/target/target_report.h"
#include "renderer/renderer.h"
#include "scenes/files/assets.h"
#include "scenes/files/input_error.h"
#include "scenes/picture/picture_file.h"
#include "scenes/target/target.h"

namespace sightline {
namespace {

struct ListArguments {
  std::string what;
  std::string table;
  bool is_markdown = false;
  bool is_json = false;
};

// The picture of a target that is shown alone, where the terminal can.
void print_picture(const std::string& name) {
  const std::vector<std::string> targets = target_names();
  const bool is_target = std::find(targets.begin(), targets.end(), name) != targets.end();
  if (!is_target || !shows_pictures()) return;
  const Scene scene = picture_scene(load_target(name), TargetArguments().theta_deg);
  const Frame frame = Renderer().render(scene, RandomStream(0, "picture", 0));
  std::cout << terminal_picture(png_bytes(frame.image));
}

void print_list(const ListArguments& arguments) {
  if (arguments.what != "keys") {
    if (!arguments.table.empty()) {
      throw InputError("list: a table belongs to `sightline list keys`");
    }
    if (arguments.is_markdown && arguments.what != "columns") {
      throw InputError("list: --markdown belongs to `sightline list keys` and `list columns`");
    }
    if (arguments.is_markdown) std::cout << page_licence();
    std::cout << (arguments.is_json ? catalogue_json(arguments.what)
                                    : shown(catalogue_lists(arguments.what)));
    if (!arguments.is_json) print_picture(arguments.what);
  } else if (arguments.is_markdown) {
    if (!arguments.table.empty()) throw InputError("list keys: --markdown is of all tables");
    std::cout << key_page();
  } else {
    std::cout << (arguments.is_json ? key_json(arguments.table) : shown(key_list(arguments.table)));
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
  CLI::Option* markdown =
      sub->add_flag("--markdown", arguments->is_markdown,
                    "Of keys and columns: as the page docs/keys.md or docs/columns.md");
  sub->add_flag("--json", arguments->is_json, "Print JSON instead of the lists")
      ->excludes(markdown);
  sub->callback([arguments] { print_list(*arguments); });
}

}  // namespace sightline
