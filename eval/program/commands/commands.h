// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The commands of the program, one file each. To add one: write eval/program/commands/<name>.cpp
// with a function as these, declare it here, call it in eval/program/commands.cpp, and list the file
// in eval/CMakeLists.txt.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace sightline {

// Each adds its subcommand to the program. Parsing runs the one that was named, which throws
// InputError. `command` is the line as typed, for manifests; `exit_code` is set where a command
// ends with another than 0.

/// `study`: 4 when trials could not be run.
void add_study(CLI::App& app, const std::string& command, int& exit_code);

/// `render`: 1 when --verify finds something, 4 when scenes could not be imaged.
void add_render(CLI::App& app, int& exit_code);

/// `evaluate`, extractors and solvers over an existing image set as a run like a study's: 4 when
/// trials could not be run.
void add_evaluate(CLI::App& app, const std::string& command, int& exit_code);

/// `score`: 3 when a requirement is not met.
void add_score(CLI::App& app, int& exit_code);

/// `merge`: 4 when trials could not be run.
void add_merge(CLI::App& app, const std::string& command, int& exit_code);

void add_report(CLI::App& app);
void add_export(CLI::App& app);

/// `compare`: 3 when it finds a regression.
void add_compare(CLI::App& app, int& exit_code);

/// `solve` and `align`: 1 where there is no answer.
void add_solve(CLI::App& app, int& exit_code);
void add_align(CLI::App& app, int& exit_code);

void add_coverage(CLI::App& app);
/// `demo`: 4 when trials could not be run.
void add_demo(CLI::App& app, const std::string& command, int& exit_code);

/// `manual` and `completions`, of all commands that `app` has when one of them runs.
void add_manual(CLI::App& app);
void add_completions(CLI::App& app);

void add_list(CLI::App& app);
void add_target(CLI::App& app);
void add_bound(CLI::App& app);
void add_doctor(CLI::App& app);

}  // namespace sightline
