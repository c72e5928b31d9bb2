// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
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
#include "scenes/files/toml_text.h"

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

// The parts between the commas that stand in no brackets and no quotes, without blanks about them.
std::vector<std::string> parts_of(std::string_view values) {
  std::vector<std::string> parts(1);
  int depth = 0;
  char quote = 0;
  for (const char c : values) {
    const bool is_quote = c == '"' || c == '\'';
    if (is_quote && (quote == 0 || quote == c)) quote = quote == 0 ? c : 0;
    if (quote == 0) depth += (c == '[' || c == '{') - (c == ']' || c == '}');
    if (c == ',' && quote == 0 && depth == 0) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  for (std::string& part : parts) {
    part.erase(0, part.find_first_not_of(' '));
    part.erase(part.find_last_not_of(' ') + 1);
  }
  return parts;
}

// --over KEY=v1,v2,... is a sweep of that key, whose values are typed as those of --set are.
std::string sweep_of(const std::string& over) {
  const size_t equals = over.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == over.size()) {
    throw InputError(fmt::format(
        "--over is \"{}\", must be KEY=VALUE,VALUE,... such as image.psf_sigma_px=0.5,1", over));
  }
  std::vector<std::string> values;
  for (const std::string& part : parts_of(std::string_view(over).substr(equals + 1))) {
    const std::optional<std::string> value = typed_value(part);
    if (!value) throw InputError(fmt::format("--over {}: {} is no value", over, part));
    values.push_back(*value);
  }
  return fmt::format("sweep.\"{}\"=[{}]", over.substr(0, equals), fmt::join(values, ","));
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
