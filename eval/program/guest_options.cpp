// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/guest_options.h"

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
std::pair<std::string, std::string> named(const char* option, const std::string& given) {
  const size_t equals = given.find('=');
  if (equals != std::string::npos && equals > 0 && equals + 1 < given.size()) {
    return {given.substr(0, equals), given.substr(equals + 1)};
  }
  throw InputError(fmt::format("{} {}: must be NAME=FILE", option, given));
}

}  // namespace

void add_guest_options(CLI::App& sub, GuestArguments& arguments) {
  sub.add_option("--extractor", arguments.extractors,
                 "Comma-separated, each in cells of its own: for all features that it can find "
                 "(`sightline list extractors`), a name of --observations, or by_kind: as "
                 "[extraction] says for each kind of feature")
      ->delimiter(',');
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
  std::vector<std::string> extractors = arguments.extractors;
  std::vector<std::string> tables;
  for (const std::string& given : arguments.observations) {
    const auto [name, file] = named("--observations", given);
    std::string table =
        fmt::format("{{name = {}, file = {}", toml_text(name), toml_text(absolute(file)));
    if (!arguments.pixels.empty())
      table += fmt::format(", pixels = {}", toml_text(arguments.pixels));
    if (!arguments.coco_images.empty()) {
      table += fmt::format(", images = {}", toml_text(absolute(arguments.coco_images)));
    }
    tables.push_back(table + "}");
    extractors.push_back(name);
  }
  if (!tables.empty())
    settings.push_back(fmt::format("observations=[{}]", fmt::join(tables, ", ")));
  for (std::string& name : extractors) name = toml_text(name);
  if (!extractors.empty()) {
    settings.push_back(fmt::format("extractors=[{}]", fmt::join(extractors, ", ")));
  }
  tables.clear();
  for (const std::string& given : arguments.estimates) {
    const auto [name, file] = named("--estimates", given);
    tables.push_back(
        fmt::format("{{name = {}, file = {}}}", toml_text(name), toml_text(absolute(file))));
  }
  if (!tables.empty()) settings.push_back(fmt::format("estimates=[{}]", fmt::join(tables, ", ")));
  return settings;
}

}  // namespace sightline
