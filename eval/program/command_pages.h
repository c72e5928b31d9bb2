// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The program's own words about its commands, as data: manual pages and completions are made of
// them, so that neither can say anything that the program does not.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace sightline {

struct OptionPage {
  std::vector<std::string> names;  ///< "--jobs", "-j"; of a positional one, its name alone
  std::string value;               ///< what stands after it: TEXT, INT; empty of a flag
  std::string text;
  std::vector<std::string> choices;  ///< the values that it may take, where they are few
  std::string standard;              ///< the value that it has where it is not given; may be empty
  bool is_required = false;
};

struct CommandPage {
  std::string name;  ///< "study"
  std::string text;
  std::vector<OptionPage> positionals;
  std::vector<OptionPage> options;
};

/// All commands that `sightline --help` shows, in its order.
std::vector<CommandPage> command_pages(const CLI::App& app);

/// The manual page of a command in man's language (groff's man macros), section 1.
std::string manual_page(const CommandPage& command);

/// The page sightline(1): what the program is, its commands, exit codes, environment and files.
std::string manual_page(const std::vector<CommandPage>& commands);

/// What a shell sources to complete command lines.
std::string bash_completions(const std::vector<CommandPage>& commands);
std::string zsh_completions(const std::vector<CommandPage>& commands);
std::string fish_completions(const std::vector<CommandPage>& commands);

}  // namespace sightline
