// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/doctor.h"

#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "eval/output/terminal.h"
#include "eval/program/commands/commands.h"

namespace sightline {

void add_doctor(CLI::App& app) {
  auto measures_renderer = std::make_shared<bool>(false);
  auto lists_licences = std::make_shared<bool>(false);
  auto is_json = std::make_shared<bool>(false);
  CLI::App* sub = app.add_subcommand(
      "doctor", "Say what the program stands on: libraries, folders, ways to draw, shards");
  sub->add_flag("--renderer", *measures_renderer,
                "Also measure the edges, vertices and time of every number of samples");
  sub->add_flag("--licences", *lists_licences,
                "Instead, the libraries that it is made of, with their licences");
  sub->add_flag("--json", *is_json, "Print JSON instead of the lists");
  sub->callback([measures_renderer, lists_licences, is_json] {
    if (*is_json) {
      std::cout << (*lists_licences ? licences_json() : doctor_json(*measures_renderer));
    } else {
      std::cout << shown(*lists_licences ? library_licences() : doctor(*measures_renderer));
    }
  });
}

}  // namespace sightline
