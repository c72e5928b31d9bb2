// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "eval/output/terminal.h"
#include "eval/program/bound_charts.h"
#include "eval/program/commands/commands.h"
#include "eval/report/gnuplot.h"
#include "eval/study/study_file.h"
#include "eval/target/image_bound_report.h"
#include "scenes/files/input_error.h"

namespace sightline {
namespace {

struct BoundArguments {
  std::string study;
  std::vector<std::string> over;
  std::string csv;
  std::string figures;
  int scenes = 10;
  bool is_json = false;
  StudyOverrides overrides;
};

bool is_bare_word(std::string_view text) {
  constexpr std::array<std::string_view, 4> kValues = {"true", "false", "inf", "nan"};
  const auto is_of_word = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  };
  return !text.empty() && std::isalpha(static_cast<unsigned char>(text.front())) != 0 &&
         std::ranges::all_of(text, is_of_word) && std::ranges::find(kValues, text) == kValues.end();
}

// Bare words between commas in the quotes that TOML wants, as --set takes a bare word.
std::string with_quoted_words(std::string_view values) {
  std::string out;
  while (true) {
    const size_t comma = values.find(',');
    const std::string_view value = values.substr(0, comma);
    out += is_bare_word(value) ? fmt::format("\"{}\"", value) : std::string(value);
    if (comma == std::string_view::npos) return out;
    out += ',';
    values.remove_prefix(comma + 1);
  }
}

// --over KEY=v1,v2,... is a sweep of that key.
std::string sweep_of(const std::string& over) {
  const size_t equals = over.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == over.size()) {
    throw InputError(fmt::format(
        "--over is \"{}\", must be KEY=VALUE,VALUE,... such as image.psf_sigma_px=0.5,1", over));
  }
  return fmt::format("sweep.\"{}\"=[{}]", over.substr(0, equals),
                     with_quoted_words(std::string_view(over).substr(equals + 1)));
}

void write_csv(const std::string& name, const std::vector<ImageBoundRow>& rows) {
  std::ofstream file(name);
  file << image_bound_csv(rows);
  file.flush();
  if (!file) throw InputError(fmt::format("{}: cannot be written", name));
}

void draw_charts(const std::string& folder, const std::vector<Chart>& charts) {
  const std::string note = write_figures(folder, charts);
  if (!note.empty()) std::cerr << note << "\n";
}

void print_bound(BoundArguments arguments) {
  for (const std::string& over : arguments.over) {
    arguments.overrides.set.push_back(sweep_of(over));
  }
  const Study study = read_scene(arguments.study, arguments.overrides);
  if (!study.renders()) {
    throw InputError(
        fmt::format("{}: has images already, of which nobody knows the light: a bound "
                    "is of scenes that are rendered",
                    arguments.study));
  }
  const std::vector<ImageBoundRow> rows = image_bound_rows(study, arguments.scenes);
  std::cout << (arguments.is_json ? image_bound_json(study.title, rows)
                                  : shown(image_bound_table(study.title, rows)));
  if (!arguments.csv.empty()) write_csv(arguments.csv, rows);
  if (!arguments.figures.empty()) {
    draw_charts(arguments.figures, bound_charts(study.conditions, rows));
  }
}

}  // namespace

void add_bound(CLI::App& app) {
  auto arguments = std::make_shared<BoundArguments>();
  CLI::App* sub = app.add_subcommand(
      "bound",
      "Say how well any estimator could know the pose from a study's images, before a run");
  sub->add_option("study", arguments->study, "Name or file of an image study or a scene")
      ->required();
  sub->add_option("--scenes", arguments->scenes, "Scenes of each condition")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub->add_option("--over", arguments->over,
                  "KEY=VALUE,VALUE,...: a row for each value of a key, such as "
                  "image.psf_sigma_px=0.5,1 or, of a key that is a range, "
                  "poses.range_m=[1000,1000],[2000,2000]; may be repeated")
      ->allow_extra_args(false);
  sub->add_option("--set", arguments->overrides.set, "key=value of the study; may be repeated")
      ->allow_extra_args(false);
  sub->add_option("--seed", arguments->overrides.seed, "Seed of all draws");
  sub->add_option("--csv", arguments->csv, "Also write the rows into this file");
  sub->add_option("--figures", arguments->figures,
                  "Also draw charts over the conditions, such as the values of --over, into this "
                  "folder: bound-theta.svg and bound-t.svg, with their data and gnuplot's scripts");
  sub->add_flag("--json", arguments->is_json, "Print JSON instead of the table");
  sub->callback([arguments] { print_bound(*arguments); });
}

}  // namespace sightline
