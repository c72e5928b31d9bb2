// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/guest_options.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenes/files/input_error.h"
#include "scenes/files/toml_text.h"

namespace sightline {
namespace {

namespace fs = std::filesystem;

std::string absolute(const std::string& file) {
  return fs::absolute(file).lexically_normal().string();
}

// A guest's name and what stands for it.
std::pair<std::string, std::string> named(const char* option, const std::string& given,
                                          const char* what = "FILE") {
  const size_t equals = given.find('=');
  if (equals != std::string::npos && equals > 0 && equals + 1 < given.size()) {
    return {given.substr(0, equals), given.substr(equals + 1)};
  }
  throw InputError(fmt::format("{} {}: must be NAME={}", option, given, what));
}

std::vector<std::string> parted_at_commas(const std::string& list) {
  std::vector<std::string> parts;
  for (size_t begin = 0; begin <= list.size();) {
    const size_t end = std::min(list.find(',', begin), list.size());
    parts.push_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

std::string process_table(const std::string& name, const std::string& command) {
  return fmt::format("{{name = {}, command = {}}}", toml_text(name), toml_text(command));
}

std::string observations_table(const std::string& name, const std::string& file,
                               const GuestArguments& arguments) {
  std::string table =
      fmt::format("{{name = {}, file = {}", toml_text(name), toml_text(absolute(file)));
  if (!arguments.pixels.empty()) table += fmt::format(", pixels = {}", toml_text(arguments.pixels));
  if (!arguments.coco_images.empty()) {
    table += fmt::format(", images = {}", toml_text(absolute(arguments.coco_images)));
  }
  return table + "}";
}

}  // namespace

void add_guest_options(CLI::App& sub, GuestArguments& arguments) {
  sub.add_option("--extractor", arguments.extractors,
                 "Comma-separated, each in cells of its own: for all features that it can find "
                 "(`sightline list extractors`), a name of --observations, or by_kind: as "
                 "[extraction] says for each kind of feature. Or NAME='COMMAND': a process that is "
                 "asked (docs/external.md); may be repeated")
      ->allow_extra_args(false);
  sub.add_option("--solver", arguments.solvers,
                 "NAME='COMMAND': a process that is asked for the pose of every trial, as a solver "
                 "of that name (docs/external.md); may be repeated")
      ->allow_extra_args(false);
  sub.add_option(
         "--observations", arguments.observations,
         "NAME=FILE: features that another program found, as an extractor of that name; CSV "
         "(scene_id,im_id[,gt_id],feature,u,v[,sigma][,confidence]) or COCO keypoint "
         "results (.json); may be repeated")
      ->allow_extra_args(false);
  sub.add_option("--pixels", arguments.pixels,
                 "Where those files have (0, 0): at the top-left pixel's centre (centres), its "
                 "corner (corners), or so and over width and height (normalised) [centres]")
      ->check(CLI::IsMember({"centres", "corners", "normalised"}));
  sub.add_option("--coco-images", arguments.coco_images,
                 "COCO annotations that say which picture an image_id of those files is [it is the "
                 "im_id]");
  sub.add_option("--estimates", arguments.estimates,
                 "NAME=FILE: poses that another program estimated, as a solver of that name; BOP "
                 "results CSV, ESA's CSV or results.csv of a run; may be repeated")
      ->allow_extra_args(false);
}

std::vector<std::string> guest_settings(const GuestArguments& arguments) {
  std::vector<std::string> settings;
  const auto set = [&settings](const char* key, const std::vector<std::string>& values) {
    if (!values.empty()) settings.push_back(fmt::format("{}=[{}]", key, fmt::join(values, ", ")));
  };
  std::vector<std::string> extractors;
  std::vector<std::string> processes;
  for (const std::string& given : arguments.extractors) {
    if (given.find('=') == std::string::npos) {
      for (const std::string& name : parted_at_commas(given)) extractors.push_back(toml_text(name));
      continue;
    }
    const auto [name, command] = named("--extractor", given, "COMMAND");
    processes.push_back(process_table(name, command));
    extractors.push_back(toml_text(name));
  }
  set("external.extractor", processes);
  std::vector<std::string> tables;
  for (const std::string& given : arguments.observations) {
    const auto [name, file] = named("--observations", given);
    tables.push_back(observations_table(name, file, arguments));
    extractors.push_back(toml_text(name));
  }
  set("observations", tables);
  set("extractors", extractors);
  tables.clear();
  for (const std::string& given : arguments.estimates) {
    const auto [name, file] = named("--estimates", given);
    tables.push_back(
        fmt::format("{{name = {}, file = {}}}", toml_text(name), toml_text(absolute(file))));
  }
  set("estimates", tables);
  tables.clear();
  for (const std::string& given : arguments.solvers) {
    const auto [name, command] = named("--solver", given, "COMMAND");
    tables.push_back(process_table(name, command));
  }
  set("external.solver", tables);
  return settings;
}

}  // namespace sightline
