// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace CLI {
class App;
}

namespace sightline {

/// Adds the subcommand `score` to the program.
void add_score(CLI::App& app);

}  // namespace sightline
