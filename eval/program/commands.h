// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace sightline {

/// Adds the subcommands to the program. Parsing runs the one that was named; it throws InputError,
/// and sets `exit_code` to 3 when `compare` found a regression or `score` what is not as required,
/// to 4 when trials could not be run
/// or scenes not imaged, and to 1 when a set that is verified is not sound. `command` is the line
/// as typed, for manifests.
void add_commands(CLI::App& app, const std::string& command, int& exit_code);

}  // namespace sightline
