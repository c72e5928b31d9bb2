// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace CLI {
class App;
}

namespace sightline {

/// Adds the subcommand `render` to the program. Sets `exit_code` to 1 when --verify finds something
/// and to 4 when scenes could not be imaged.
void add_render(CLI::App& app, int& exit_code);

}  // namespace sightline
