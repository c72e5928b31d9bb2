// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/run/export.h"

#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "eval/output/output_folder.h"
#include "eval/program/commands/commands.h"

namespace sightline {
namespace {

const std::map<std::string, ExportFormat> kFormats = {
    {"bop", ExportFormat::kBop}, {"speed", ExportFormat::kSpeed}, {"coco", ExportFormat::kCoco}};

struct ExportArguments {
  ExportRequest request;
  std::string format = "bop";
  std::string out;
};

void run_export(ExportArguments arguments) {
  arguments.request.format = kFormats.at(arguments.format);
  const std::string text = export_run(arguments.request);
  if (arguments.out.empty()) {
    std::cout << text;
  } else {
    write_file(arguments.out, text);
  }
}

}  // namespace

void add_export(CLI::App& app) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* sub =
      app.add_subcommand("export", "Write what a run found as other people's tools read it");
  sub->add_option("run", arguments->request.run, "Folder of a run")->required();
  sub->add_option("--format", arguments->format,
                  "bop: results CSV of BOP; speed: ESA's CSV of poses; coco: keypoint results, the "
                  "features as they were found")
      ->check(CLI::IsMember({"bop", "speed", "coco"}))
      ->capture_default_str();
  sub->add_option(
      "--solver", arguments->request.solver,
      "Whose poses [the only one]; of coco: features that it removed count as not found");
  sub->add_option("--condition", arguments->request.condition,
                  "Label of the condition whose trials count, where a run has several");
  sub->add_option("--scene", arguments->request.scene,
                  "Of a run of several scenes, the one that is written [all]")
      ->check(CLI::NonNegativeNumber);
  sub->add_option("--out", arguments->out, "File to write [standard output]");
  sub->callback([arguments] { run_export(*arguments); });
}

}  // namespace sightline
