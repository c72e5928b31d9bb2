// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The options by which `study` and `evaluate` are told of guests: other people's observations,
// estimates and processes.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace sightline {

struct GuestArguments {
  std::vector<std::string> solvers;       ///< "NAME=COMMAND"
  std::vector<std::string> extractors;    ///< "NAME=COMMAND", or names, guests or not
  std::vector<std::string> observations;  ///< "NAME=FILE"
  std::string pixels;                     ///< of all those files; empty: their formats' own
  std::string coco_images;                ///< COCO annotations that go with them; may be empty
  std::vector<std::string> estimates;     ///< "NAME=FILE"
};

void add_guest_options(CLI::App& sub, GuestArguments& arguments);

/// The same as settings over a study's file ("key=value"): they take the place of what the file
/// says of guests. Throws InputError for a "NAME=FILE" that is
/// none.
std::vector<std::string> guest_settings(const GuestArguments& arguments);

}  // namespace sightline
