// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace sightline {

/// Adds `evaluate`: extractors and solvers over an existing image set, as a run like a study's.
/// `exit_code` and `command` are as in add_commands.
void add_evaluate(CLI::App& app, const std::string& command, int& exit_code);

}  // namespace sightline
