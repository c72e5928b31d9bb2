// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
#include "eval/program/commands.h"

#include "eval/program/commands/commands.h"

namespace sightline {

void add_commands(CLI::App& app, const std::string& command, int& exit_code) {
  add_demo(app, command, exit_code);
  add_study(app, command, exit_code);
  add_render(app, exit_code);
  add_evaluate(app, command, exit_code);
  add_score(app, exit_code);
  add_merge(app, command, exit_code);
  add_report(app);
  add_export(app);
  add_compare(app, exit_code);
  add_solve(app, exit_code);
  add_align(app, exit_code);
  add_coverage(app);
  add_list(app);
  add_target(app);
  add_bound(app);
  add_doctor(app);
  add_manual(app);
  add_completions(app);
}

}  // namespace sightline
